"use strict";
// The receptance over the places that the tool comes to: postures known at each of them, and the best of these.
const Workspace = (() => {
  const SAMPLES = 8000; // postures drawn, to see where the tool comes to
  const CELLS = { 2: 26, 3: 11 }; // along the widest side, of a plane and of space
  const KNOWN = { 2: 8, 3: 5 }; // postures kept at a place
  const SEED = 2026;
  const MOST = 1500; // places
  const SWEEPS = 12;
  const GAIN = 0.01; // a posture of a neighbour that is better by less is not kept
  const CROWD = 24; // postures at a place
  const DESCENTS = 150; // at most, of places that are seen
  const SHORT = 12; // rounds of each

  // Steps of the work, so that the page stays awake: yields the part that is done, returns the map; `across` says how
  // many cells go along the widest side.
  function* lay(robot, across = null) {
    const next = Descent.chance(SEED);
    const { joints, points } = robot.numbers;
    const drawn = [];
    for (let k = 0; k < SAMPLES; k++) {
      const q = Descent.anywhere(robot, next);
      drawn.push({ q, at: Chain.position(Chain.frames(joints, q), points.tool) });
      if (k % 500 === 0) yield 0.1 * (k / SAMPLES);
    }
    const low = [0, 1, 2].map((axis) => Math.min(...drawn.map(({ at }) => at[axis])));
    const high = [0, 1, 2].map((axis) => Math.max(...drawn.map(({ at }) => at[axis])));
    const wide = Math.max(...high.map((value, axis) => value - low[axis]));
    const spread = [0, 1, 2].filter((axis) => high[axis] - low[axis] > 1e-6 * wide);
    for (const axis of [0, 2, 1]) if (spread.length < 2 && !spread.includes(axis)) spread.push(axis); // a line has squares too
    spread.sort();
    const kind = spread.length < 3 ? 2 : 3;
    const cell = Math.max(wide, 1e-3) / (across || CELLS[kind]);
    const cells = new Map();
    for (const one of drawn) {
      const index = one.at.map((value, axis) => (spread.includes(axis) ? Math.floor((value - low[axis]) / cell) : 0));
      const key = index.join(" ");
      if (!cells.has(key)) cells.set(key, { index, some: [] });
      if (cells.get(key).some.length < KNOWN[kind]) cells.get(key).some.push(one.q);
    }
    const middle = (index) => index.map((count, axis) => (spread.includes(axis) ? low[axis] + (count + 0.5) * cell : (low[axis] + high[axis]) / 2));
    const places = [];
    const numbers = new Map(); // of the places, by their cells
    function settle(index, some) { // postures brought to the middle of a cell
      const at = middle(index);
      const known = some.map((q) => Descent.bring(robot, q, "tool", at)).filter((q) => q !== null).map((q) => robot.at(q));
      if (known.length) { numbers.set(index.join(" "), places.length); places.push({ at, index, known }); }
    }
    const beside = (index) => spread.flatMap((axis) => [-1, 1].map((step) => index.map((count, k) => count + (k === axis ? step : 0))));
    let done = 0;
    for (const { index, some } of cells.values()) {
      settle(index, some);
      done += 1;
      if (done % 5 === 0) yield 0.1 + 0.7 * (done / cells.size);
    }
    const tried = new Set(cells.keys());
    for (let number = 0; number < places.length && places.length < MOST; number++) { // what lies beside and was not drawn
      for (const index of beside(places[number].index)) {
        const key = index.join(" ");
        if (numbers.has(key) || (tried.has(key) && number < cells.size)) continue;
        tried.add(key);
        settle(index, places[number].known.slice(0, 3).map(({ q }) => q));
      }
      if (number % 5 === 0) yield 0.8 + 0.2 * (number / places.length);
    }
    for (const place of places) place.beside = beside(place.index).map((index) => numbers.get(index.join(" "))).filter((number) => number !== undefined);
    return { places, cell, spread };
  }

  // A posture for a place, kept where it is better than what was known.
  function learn(place, judged, number, posed, found) {
    if (!(found < judged[number].value * (1 - GAIN))) return false;
    place.known.push(posed);
    if (place.known.length > CROWD) place.known.splice(place.known.indexOf(judged[number].posed), 1);
    judged[number] = { value: found, posed };
    return true;
  }

  // The best postures of the places beside each place are brought there, over and over until that gains nothing.
  // Yields whether anything was gained since the last time.
  function* spread(robot, map, value, judged, fresh) {
    for (let sweep = 0; sweep < SWEEPS && fresh.size; sweep++) {
      const gained = new Set();
      for (const number of map.places.keys()) {
        const place = map.places[number];
        for (const other of place.beside) {
          if (!fresh.has(other) || judged[other].value >= judged[number].value) continue;
          const q = Descent.bring(robot, judged[other].posed.q, "tool", place.at);
          const posed = q === null ? null : robot.at(q);
          if (posed !== null && learn(place, judged, number, posed, value(posed))) gained.add(number);
        }
        yield gained.has(number);
      }
      fresh = gained;
    }
  }

  // Places learn from one another; then some of those that are seen by a short descent each, and all from these.
  function* refine(robot, map, value, seen) {
    const judged = judge(map, value);
    yield* spread(robot, map, value, judged, new Set(map.places.keys()));
    const gained = new Set();
    const stride = Math.ceil(seen.length / DESCENTS);
    for (let k = 0; k < seen.length; k += stride) {
      const number = seen[k];
      const found = Descent.descend(robot, judged[number].posed.q, "tool", value, SHORT);
      const better = learn(map.places[number], judged, number, robot.at(found.q), found.value);
      if (better) gained.add(number);
      yield better;
    }
    yield* spread(robot, map, value, judged, gained);
  }

  // The least value at each place, and the posture that has it; `value(posed)` as everywhere.
  function judge(map, value) {
    return map.places.map(({ known }) => {
      let best = { value: Infinity, posed: known[0] };
      for (const posed of known) {
        const found = value(posed);
        if (found < best.value) best = { value: found, posed };
      }
      return best;
    });
  }

  const STARTS = 16;
  // The best posture at a place by descents from those known there and from others drawn; yields the best so far.
  function* best(robot, place, value) {
    const next = Descent.chance(SEED + 1);
    const starts = [...place.known.map(({ q }) => q)];
    for (let k = 0; k < 200 && starts.length < STARTS; k++) {
      const q = Descent.bring(robot, Descent.anywhere(robot, next), "tool", place.at);
      if (q !== null) starts.push(q);
      if (k % 10 === 9) yield null;
    }
    let least = null;
    for (const start of starts) {
      const found = Descent.descend(robot, start, "tool", value);
      if (least === null || found.value < least.value) least = found;
      yield least;
    }
    return { ...least, starts: starts.length };
  }

  return { lay, judge, refine, best };
})();
