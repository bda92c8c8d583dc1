"use strict";
// A posture search gone through: all its descents step by step on one slider, the optima in a list.
const Film = (() => {
  const SECONDS = 6; // of the whole film

  // The descents as curves over their steps, that of the arm thick; where each stands now as a dot.
  function drawn(svg, descents, chosen, at, most) {
    svg.replaceChildren();
    const logs = descents.map(({ steps }) => steps.map(({ value }) => (value > 0 ? Math.log10(value) : NaN)));
    const known = logs.flat().filter(Number.isFinite);
    const [low, high] = [Math.min(...known), Math.max(...known)];
    const [width, height] = [svg.clientWidth || 300, svg.clientHeight || 64];
    const x = (step) => 5 + (step / most) * (width - 10);
    const y = (log) => 6 + ((high - log) / (high - low || 1)) * (height - 12);
    const order = descents.map((_, number) => number).sort((a, b) => (a === chosen) - (b === chosen));
    for (const number of order) {
      const points = logs[number].map((log, step) => (Number.isFinite(log) ? `${x(step).toFixed(1)} ${y(log).toFixed(1)}` : null)).filter(Boolean);
      if (!points.length) continue;
      Chart.element(svg, "path", { class: number === chosen ? "curve live" : "curve other", d: `M${points.join("L")}` });
      const now = Math.min(Math.round(at), logs[number].length - 1);
      if (Number.isFinite(logs[number][now])) Chart.element(svg, "circle", { class: number === chosen ? "here" : "there", cx: x(Math.min(at, logs[number].length - 1)), cy: y(logs[number][now]), r: number === chosen ? 4 : 2.2 });
    }
    Chart.element(svg, "line", { class: "here", x1: x(at), x2: x(at), y1: 2, y2: height - 2 });
  }

  // Between two steps the joints move in proportion; a descent that has ended stays.
  function between(steps, at) {
    const first = Math.min(Math.floor(at), steps.length - 1);
    const next = Math.min(first + 1, steps.length - 1);
    const part = Math.min(at, steps.length - 1) - first;
    return steps[first].q.map((value, k) => value + part * (steps[next].q[k] - value));
  }

  function make(live, search) {
    const { by } = Panel;
    const { joints } = live.robot.numbers;
    const vector = (q) => joints.map(({ name }) => q[name] || 0);
    const text = (value) => (value === null ? "infinite" : Units.quantity(value, search.unit));
    const descents = search.descents.map(({ name, end, steps }) => ({ name, end, steps: steps.map(({ q, value }) => ({ q: vector(q), value })) }));
    const most = Math.max(0, ...descents.map(({ steps }) => steps.length - 1));
    let chosen = 0;
    by("search").hidden = false;
    by("film").hidden = most < 1;

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
    const sticks = live.picture && descents.length > 1 ? Sticks.make(window.flexmodalPage, live.robot, live.reach, descents.length) : null;
    const ends = descents.flatMap(({ steps }) => steps.map(({ value }) => value)).filter((value) => value > 0).map(Math.log10);
    const [low, high] = [Math.min(...ends), Math.max(...ends)];
    const lightness = (value) => { // small is light, where small is good
      if (value === null) return 0;
      const part = value > 0 ? (Math.log10(value) - low) / (high - low || 1) : 0;
      return search.large ? part : 1 - part;
    };
    const valueAt = ({ steps }, at) => steps[Math.min(Math.round(at), steps.length - 1)].value;
    function others(at) {
      if (sticks === null) return;
      sticks.visible(by("film-all").checked);
      sticks.show(descents.map(({ steps }) => between(steps, at)), descents.map((one) => lightness(valueAt(one, at))), chosen);
    }
    function words(at) {
      const { steps, end } = descents[chosen];
      const now = Math.min(Math.round(at), steps.length - 1);
      const goes = end === null ? "ends in none of those listed" : `ends in optimum ${end + 1}`;
      by("descent-says").textContent = `step ${now} of ${steps.length - 1}: ${text(steps[now].value)}; ${goes}`;
      slider.setAttribute("aria-valuetext", by("descent-says").textContent);
    }
    function show(at) {
      slider.value = at;
      drawn(svg, descents, chosen, at, most);
      words(at);
      others(at);
      live.go(between(descents[chosen].steps, at));
    }

    let began = null;
    function stop() { began = null; by("play-film").textContent = "Play"; }
    function turn(now) {
      if (began === null) return;
      const gone = Math.max(now - began, 0) / 1000 / SECONDS; // a frame may be stamped before it was asked for
      const at = Math.min(gone, 1) * most;
      show(at);
      if (at < most) requestAnimationFrame(turn);
      else stop();
    }
    if (most >= 1) {
      slider.max = most;
      slider.addEventListener("input", () => { stop(); show(Number(slider.value)); });
      slider.addEventListener("keydown", (event) => {
        const sense = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1, PageUp: 10, PageDown: -10 }[event.key];
        if (sense === undefined) return;
        event.preventDefault();
        stop();
        show(Math.min(Math.max(Number(slider.value) + sense, 0), most));
      });
      by("play-film").addEventListener("click", () => {
        if (began !== null) { stop(); return; }
        by("play-film").textContent = "Stop";
        began = performance.now();
        requestAnimationFrame(turn);
      });
      Panel.options(by("film-of"), descents.map(({ name }, number) => [String(number), name]), "0");
      by("film-of").addEventListener("change", () => { chosen = Number(by("film-of").value); show(Number(slider.value)); });
      by("film-all").addEventListener("change", () => others(Number(slider.value)));
      by("film-all").closest("label").hidden = descents.length < 2;
      by("film-of").closest(".line").hidden = descents.length < 2;
      slider.value = most;
      drawn(svg, descents, chosen, most, most);
      const { steps } = descents[0];
      by("descent-says").textContent = `${descents[0].name}: from ${text(steps[0].value)} to ${text(steps[steps.length - 1].value)} in ${steps.length - 1} steps`;
    }
    if (search.start) { // its curve stays on the axes
      const { re, im } = live.robot.at(vector(search.start)).frf(live.found().lines, live.state.response, live.state.reference);
      live.state.pinned = Array.from(re, (value, i) => Math.hypot(value, im[i]));
      by("pin").textContent = "Unpin";
      live.update(true);
    }
    if (search.held) { // what the search left free is on a slider from the start
      live.state.hold = search.held;
      document.querySelector(`input[name=hold][value=${search.held}]`).checked = true;
      live.lay();
    }
    if (window.flexmodalPage) window.flexmodalPage.film = (part) => show(part * most);
    return { show, descents, stop, choose: (number) => { chosen = number; by("film-of").value = String(number); } };
  }

  return { make };
})();
