"use strict";
// A row of colours that grows lighter from end to end and is read without telling red from green: cividis
// (Nuñez, Anderton and Renslow, PLoS ONE 13, 2018), its ninths.
const Colours = (() => {
  const STOPS = [
    [0, 34, 78], [26, 56, 111], [67, 78, 108], [97, 101, 111], [125, 124, 120], [155, 148, 118], [188, 174, 108], [222, 201, 88], [254, 232, 56],
  ];

  // Of a part from 0, dark, to 1, light.
  function at(part) {
    const place = Math.min(Math.max(part, 0), 1) * (STOPS.length - 1);
    const below = Math.min(Math.floor(place), STOPS.length - 2);
    return STOPS[below].map((value, k) => Math.round(value + (place - below) * (STOPS[below + 1][k] - value)));
  }
  const css = (part) => `rgb(${at(part).join(", ")})`;

  return { at, css };
})();
