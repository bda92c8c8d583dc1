"use strict";
// A posture search gone through: the descent from the start on a slider, the optima in a list.
const Film = (() => {
  const SECONDS = 6; // of the whole film

  function make(live, search) {
    const { by } = Panel;
    const { joints } = live.robot.numbers;
    const vector = (q) => joints.map(({ name }) => q[name] || 0);
    const text = (value) => (value === null ? "infinite" : Units.quantity(value, search.unit));
    const steps = search.descent.map(({ q, value }) => ({ q: vector(q), value }));
    by("search").hidden = false;
    by("film").hidden = steps.length < 2;

    const body = by("optima").tBodies[0];
    search.optima.forEach((one, number) => {
      const button = Panel.make("button", { type: "button", textContent: String(number + 1), ariaLabel: `go to optimum ${number + 1}` });
      button.addEventListener("click", () => { stop(); live.go(vector(one.q)); });
      body.append(Panel.make("tr", {}, [
        Panel.make("th", { scope: "row" }, [button]),
        Panel.make("td", { textContent: text(one.value) }),
        Panel.make("td", { textContent: String(one.hits) }),
      ]));
    });

    const slider = by("step");
    const svg = by("descent");
    const logs = steps.map(({ value }) => (value > 0 ? Math.log10(value) : NaN));
    const known = logs.filter(Number.isFinite);

    function draw(at) {
      svg.replaceChildren();
      const [width, height] = [svg.clientWidth || 300, svg.clientHeight || 64];
      const [low, high] = [Math.min(...known), Math.max(...known)];
      const x = (step) => 5 + (step / (steps.length - 1)) * (width - 10);
      const y = (log) => 6 + ((high - log) / (high - low || 1)) * (height - 12);
      const points = logs.map((log, step) => (Number.isFinite(log) ? `${x(step).toFixed(1)} ${y(log).toFixed(1)}` : null)).filter(Boolean);
      Chart.element(svg, "path", { class: "curve live", d: `M${points.join("L")}` });
      Chart.element(svg, "line", { class: "here", x1: x(at), x2: x(at), y1: 2, y2: height - 2 });
    }

    // Between two steps the joints move in proportion.
    function show(at) {
      const first = Math.min(Math.floor(at), steps.length - 2);
      const part = at - first;
      const [a, b] = [steps[first], steps[first + 1]];
      slider.value = at;
      draw(at);
      const near = steps[Math.round(at)];
      by("descent-says").textContent = `step ${Math.round(at)} of ${steps.length - 1}: ${text(near.value)}`;
      slider.setAttribute("aria-valuetext", by("descent-says").textContent);
      live.state.q = a.q.map((value, k) => value + part * (b.q[k] - value));
      live.update();
    }

    let began = null;
    function stop() { began = null; by("play-film").textContent = "Play"; }
    function turn(now) {
      if (began === null) return;
      const gone = Math.max(now - began, 0) / 1000 / SECONDS; // a frame may be stamped before it was asked for
      const at = Math.min(gone, 1) * (steps.length - 1);
      show(at);
      if (at < steps.length - 1) requestAnimationFrame(turn);
      else stop();
    }
    if (steps.length >= 2) {
      slider.max = steps.length - 1;
      slider.addEventListener("input", () => { stop(); show(Number(slider.value)); });
      slider.addEventListener("keydown", (event) => {
        const sense = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1, PageUp: 10, PageDown: -10 }[event.key];
        if (sense === undefined) return;
        event.preventDefault();
        stop();
        show(Math.min(Math.max(Number(slider.value) + sense, 0), steps.length - 1));
      });
      by("play-film").addEventListener("click", () => {
        if (began !== null) { stop(); return; }
        by("play-film").textContent = "Stop";
        began = performance.now();
        requestAnimationFrame(turn);
      });
      slider.value = steps.length - 1;
      draw(steps.length - 1);
      by("descent-says").textContent = `from ${text(steps[0].value)} to ${text(steps[steps.length - 1].value)} in ${steps.length - 1} steps`;
    }
    if (search.start) { // its curve stays on the axes
      const { re, im } = live.robot.at(vector(search.start)).frf(live.found().lines, live.state.response, live.state.reference);
      live.state.pinned = Array.from(re, (value, i) => Math.hypot(value, im[i]));
      by("pin").textContent = "Unpin";
      live.update(true);
    }
    return { show, steps, stop };
  }

  return { make };
})();
