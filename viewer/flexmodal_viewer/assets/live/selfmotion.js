"use strict";
// The self-motion on one slider, and the receptance along it as a small curve.
const SelfMotion = (() => {
  // tools: { robot, value(posed) to be plotted, text(value), name() of it, larger() whether it is to be large, go(q) }
  function make({ robot, value, text, name, larger, go }) {
    const { by } = Panel;
    const slider = by("along");
    const svg = by("objective");
    let way = null;
    let sizes = [];

    const gradient = (q, commanded) => { // of the logarithm, by central differences
      const step = 1e-5;
      return commanded.map((place) => {
        const [up, down] = [1, -1].map((sign) => {
          const moved = [...q];
          moved[place] += sign * step;
          return (larger() ? -1 : 1) * Math.log(Math.max(value(robot.at(moved)), 1e-300));
        });
        return (down - up) / (2 * step);
      });
    };

    // The way through q that first goes downhill; hidden where the tool can only be held by standing still.
    function lay(q, point, turned) {
      const { commanded } = robot.numbers;
      const free = Hold.freedom(robot, robot.at(q), point, turned);
      const slope = gradient(q, commanded);
      const downhill = slope.some((part) => Math.abs(part) > 1e-12) ? slope : commanded.map((_, k) => 1 + k);
      way = free > 0 ? Hold.selfMotion(robot, q, point, turned, downhill) : [];
      by("self-motion").hidden = way.length < 2;
      by("hold-says").textContent = way.length < 2 ? "No joint can move while the tool is held so." : "";
      if (way.length < 2) return;
      sizes = way.map((stop) => value(robot.at(stop.q)));
      slider.min = way[0].s;
      slider.max = way[way.length - 1].s;
      slider.step = "any";
      show(0);
    }

    function show(s) {
      slider.value = s;
      svg.replaceChildren();
      const [width, height] = [svg.clientWidth || 300, svg.clientHeight || 64];
      const logs = sizes.map(Math.log10);
      const [low, high] = [Math.min(...logs), Math.max(...logs)];
      const x = (at) => 4 + ((at - way[0].s) / (way[way.length - 1].s - way[0].s)) * (width - 8);
      const y = (log) => 6 + ((high - log) / (high - low || 1)) * (height - 12);
      Chart.element(svg, "path", { class: "curve live", d: "M" + way.map((stop, i) => `${x(stop.s).toFixed(1)} ${y(logs[i]).toFixed(1)}`).join("L") });
      const best = logs.indexOf(larger() ? high : low);
      Chart.element(svg, "circle", { class: "best", cx: x(way[best].s), cy: y(logs[best]), r: 3.5 });
      const here = nearest(s);
      Chart.element(svg, "line", { class: "here", x1: x(s), x2: x(s), y1: 2, y2: height - 2 });
      Chart.element(svg, "circle", { class: "here", cx: x(s), cy: y(logs[here]), r: 4.5 });
      by("objective-says").textContent = `${name()} along the self-motion: here ${text(sizes[here])}, ${larger() ? "largest" : "least"} ${text(sizes[best])}`;
      slider.setAttribute("aria-valuetext", text(sizes[here]));
    }

    const nearest = (s) => way.reduce((best, stop, i) => (Math.abs(stop.s - s) < Math.abs(way[best].s - s) ? i : best), 0);

    // Between two stops the joints are taken in proportion; the stops lie close enough for the eye, and the
    // tool is brought back to its place.
    function at(s, point, turned) {
      const i = Math.min(Math.max(way.findIndex((stop) => stop.s >= s), 1), way.length - 1);
      const [a, b] = [way[i - 1], way[i]];
      const t = Math.min(Math.max((s - a.s) / (b.s - a.s), 0), 1);
      const start = robot.at(a.q);
      const target = { position: start.position(point), turn: turned ? start.turned(point) : null };
      return Hold.reach(robot, a.q.map((value, k) => value + t * (b.q[k] - value)), point, target, { rounds: 8, damping: 0 }).q;
    }

    const ahead = (sense) => { // for keys: a hundredth of the way
      const step = (way[way.length - 1].s - way[0].s) / 100;
      return Math.min(Math.max(Number(slider.value) + sense * step, way[0].s), way[way.length - 1].s);
    };
    let held = null;
    function travel(s) {
      show(s);
      go(at(s, ...held));
    }
    slider.addEventListener("input", () => travel(Number(slider.value)));
    slider.addEventListener("keydown", (event) => {
      const sense = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1, PageUp: 10, PageDown: -10 }[event.key];
      if (sense === undefined) return;
      event.preventDefault();
      travel(ahead(sense));
    });

    return {
      lay: (q, point, turned) => { held = [point, turned]; lay(q, point, turned); },
      hide: () => { way = null; by("self-motion").hidden = true; by("hold-says").textContent = ""; },
      way: () => way,
      sizes: () => sizes,
      travel,
    };
  }

  return { make };
})();
