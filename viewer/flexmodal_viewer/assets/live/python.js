"use strict";
// The served page's line to Python: the same question that the page answers itself, answered by Pinocchio.
const Python = (() => {
  // told(answer) is called with { re, im, poles } of the latest question; state(text) says how the line is.
  function connect(told, state) {
    if (location.protocol !== "http:") return null; // a page from a file stands by itself
    let line;
    try {
      line = new WebSocket(`ws://${location.host}${location.pathname}socket`);
    } catch (error) {
      return null;
    }
    let number = 0;
    let waiting = null; // the latest question, where one is under way
    let busy = false;
    const send = (question) => { busy = true; line.send(JSON.stringify(question)); };
    line.addEventListener("open", () => { if (waiting) { send(waiting); waiting = null; } });
    line.addEventListener("close", () => state("Python has ended; the page goes on by itself."));
    line.addEventListener("message", (event) => {
      busy = false;
      const answer = JSON.parse(event.data);
      if (waiting) { send(waiting); waiting = null; }
      else if (answer.error) state(answer.error);
      else if (answer.number === number) told(answer);
    });
    return {
      ask(question) {
        number += 1;
        const numbered = { number, ...question };
        if (busy || line.readyState !== WebSocket.OPEN) waiting = numbered;
        else send(numbered);
      },
    };
  }
  return { connect };
})();
