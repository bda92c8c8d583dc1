"use strict";
// The workspace map on the page: laid in the browser, coloured for the frequency, each place a click or a line away.
const WorkspaceMap = (() => {
  const AWAKE = 12; // [ms] of work before the page may do something else
  const ENDS = [0.02, 0.98]; // of the values: what is beyond has the colour of the end

  // Runs the steps of a generator without keeping the page from anything else; `stopped()` ends it early.
  function run(steps, { each = () => {}, done, stopped = () => false }) {
    function on() {
      const began = performance.now();
      while (performance.now() - began < AWAKE) {
        if (stopped()) return;
        const { value, done: over } = steps.next();
        if (over) { done(value); return; }
        each(value);
      }
      setTimeout(on);
    }
    on();
  }

  function make(live) {
    const { by } = Panel;
    const { robot, state } = live;
    const page = window.flexmodalPage || { busy: () => {} };
    let map = null;
    let cloud = null;
    let judged = [];
    let task = 0; // of the latest click; an older one is given up
    let chosen = null;
    const shown = () => !by("map").hidden;
    const said = (text) => { by("map-says").textContent = text; };
    const where = (at) => `(${at.map((value) => Units.plain(Math.round(value * 1e3) / 1e3 + 0)).join(", ")}) m`;
    const quantity = (value) => Units.quantity(value, live.unit());

    function lay(across = null) {
      by("map-lay").disabled = true;
      page.busy(1);
      run(Workspace.lay(robot, across), {
        each: (part) => { by("map-lay").textContent = `Laying the map: ${Units.percent(part)}`; },
        done: (found) => {
          map = found;
          by("map-slices").hidden = map.spread.length < 3;
          if (live.picture) cloud = Cloud.make(page, map);
          by("map-lay").disabled = false;
          show(true);
          if (live.picture) live.picture.reframe(map.places.map(({ at }) => at));
          page.busy(-1);
        },
      });
    }
    function show(visible) {
      by("map").hidden = !visible;
      by("map-lay").textContent = visible ? "Hide the map" : "Show the map";
      if (cloud) cloud.show(visible);
      if (visible) refresh();
    }

    // Of a spatial arm only a slice is shown if that is asked: through the tool, level or upright.
    function inSlice(at) {
      const tool = live.posed().position("tool");
      const kind = map.spread.length < 3 ? "all" : by("map-shown").value;
      const half = map.cell / 2 + 1e-9;
      if (kind === "level") return Math.abs(at[2] - tool[2]) <= half;
      if (kind === "upright") {
        const size = Math.hypot(tool[0], tool[1]) || 1;
        return Math.abs((at[0] * tool[1] - at[1] * tool[0]) / size) <= half;
      }
      return true;
    }

    let painted = "";
    let shownNow = [];
    function refresh() {
      paint();
      painted = key();
      settle();
    }
    function paint() {
      judged = Workspace.judge(map, live.size);
      const values = judged.map(({ value }) => Math.log10(value)).filter(Number.isFinite).sort((a, b) => a - b);
      const [low, high] = values.length ? ENDS.map((part) => values[Math.round(part * (values.length - 1))]) : [0, 0];
      const light = ({ value }) => { // nothing moves at all, or without bound: the ends
        const log = Math.log10(value);
        return Number.isFinite(log) ? 1 - (log - low) / (high - low || 1) : Number(value === 0);
      };
      shownNow = map.places.map((_, number) => number).filter((number) => inSlice(map.places[number].at));
      if (cloud) cloud.paint(shownNow, judged.map(light));
      scale(low, high);
      list(shownNow);
      by("map-hertz").max = Math.max(state.high, state.hertz);
      by("map-hertz").value = state.hertz;
      by("map-hertz").setAttribute("aria-valuetext", `${Units.plain(state.hertz)} hertz`);
      by("map-hertz-says").textContent = `${Units.plain(state.hertz)} Hz`;
    }
    // Once the frequency rests, places learn from those beside them.
    let waiting = 0;
    let settling = null;
    function settle() {
      clearTimeout(waiting);
      if (settling !== null) page.busy(-1);
      const own = {};
      settling = own;
      page.busy(1);
      let last = performance.now();
      waiting = setTimeout(() => run(Workspace.refine(robot, map, live.size, shownNow), {
        stopped: () => settling !== own,
        each: (gained) => { if (gained && performance.now() - last > 400) { paint(); last = performance.now(); } },
        done: () => { settling = null; paint(); page.busy(-1); },
      }), 200);
    }
    const key = () => JSON.stringify([state.hertz, state.response, state.reference]);

    function scale(low, high) {
      const svg = by("map-scale");
      svg.replaceChildren();
      const width = svg.clientWidth || 300;
      const pad = 30;
      for (let k = 0; k < 60; k++) { // small is light, as small is good
        const step = (width - 2 * pad) / 60;
        Chart.element(svg, "rect", { x: pad + k * step, y: 4, width: step + 0.6, height: 14, fill: Colours.css(1 - k / 59) });
      }
      for (const part of [0, 0.5, 1]) {
        const at = pad + part * (width - 2 * pad);
        Chart.element(svg, "text", { x: at, y: 34, "text-anchor": "middle" }, Units.plain(10 ** (low + part * (high - low)), 2));
      }
      const title = `|α| [${live.unit()}], on a scale of logarithms`;
      Chart.element(svg, "text", { x: width / 2, y: 50, "text-anchor": "middle" }, title);
      svg.setAttribute("aria-label", `Colours: light is ${quantity(10 ** low)}, dark ${quantity(10 ** high)}`);
    }

    function list(numbers) {
      const order = [...numbers].sort((a, b) => judged[a].value - judged[b].value);
      const rows = order.map((number) => [String(number), `${quantity(judged[number].value)} at ${where(map.places[number].at)}`]);
      Panel.options(by("map-places"), [["", `${rows.length} places, the best first`], ...rows], chosen === null ? "" : String(chosen));
    }

    // The arm goes to the best posture known there, and from descent to descent to better ones.
    function go(number) {
      task += 1;
      const own = task;
      const place = map.places[number];
      const sample = judged[number];
      chosen = number;
      if (cloud) cloud.choose(number);
      by("map-places").value = String(number);
      said(`${where(place.at)}: looking for the best posture.`);
      live.go(sample.posed.q);
      let least = sample.value;
      page.busy(1);
      const left = () => { if (own !== task) page.busy(-1); return own !== task; };
      run(Workspace.best(robot, place, live.size), {
        stopped: left,
        each: (found) => { if (found !== null && found.value < least * (1 - 1e-6)) { least = found.value; live.go(found.q); } },
        done: (found) => {
          if (found.value < sample.value) place.known.push(robot.at(found.q));
          const best = found.value < sample.value ? found : { q: sample.posed.q, value: sample.value };
          live.go(best.q);
          paint();
          said(`${where(place.at)}: ${quantity(best.value)}, the best of ${found.starts} descents; of the postures known there before the best had ${quantity(sample.value)}.`);
          page.busy(-1);
        },
      });
    }

    by("map-lay").addEventListener("click", () => (map === null ? lay(live.cells) : show(!shown())));
    by("map-hertz").addEventListener("input", () => live.setHertz(Number(by("map-hertz").value)));
    by("map-shown").addEventListener("change", refresh);
    by("map-places").addEventListener("change", () => { if (by("map-places").value !== "") go(Number(by("map-places").value)); });
    if (live.picture) clicks();
    function clicks() {
      let from = null;
      page.stage.addEventListener("pointerdown", (event) => { from = event.button === 0 ? [event.clientX, event.clientY] : null; }, true);
      page.stage.addEventListener("pointerup", (event) => {
        if (from === null || !shown() || cloud === null || Math.hypot(event.clientX - from[0], event.clientY - from[1]) > 4) return;
        const number = cloud.near(event);
        if (number !== null) go(number);
      }, true);
    }
    live.watch(() => { if (map !== null && shown() && key() !== painted) refresh(); });

    return { lay, go, map: () => map, judged: () => judged };
  }

  return { make };
})();
