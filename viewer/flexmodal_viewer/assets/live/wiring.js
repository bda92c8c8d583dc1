"use strict";
// Controls of the page to the live view, and the address to both: #q=a:0.1,b:0.2&frequency=12&mode=2&phase=0.25.
(function () {
  const { by } = Panel;
  const data = JSON.parse(by("robot").textContent);
  const live = Live.make(data);
  const { robot, state } = live;
  const { joints, commanded, postures } = robot.numbers;
  window.flexmodalLive = live;

  for (const kind of ["response", "reference"]) {
    Panel.directions(robot, kind, data.response, (text) => { live.force(kind, text); live.update(); });
  }
  const given = ["", "as opened"];
  const tested = new Map(data.measured.map((one) => [one.posture, one.q]));
  for (const [name, q] of tested) postures.push([`${name} (measured)`, q]);
  const named = postures.map(([name], number) => [String(number), name]);
  Panel.options(by("postures"), [given, ...named], "");
  by("postures").addEventListener("change", () => {
    const values = by("postures").value === "" ? data.posture : postures[Number(by("postures").value)][1];
    state.q = joints.map(({ name }) => values[name] || 0);
    live.update();
  });
  by("pin").addEventListener("click", () => {
    const { re, im } = live.found().curve;
    state.pinned = state.pinned ? null : Array.from(re, (x, i) => Math.hypot(x, im[i]));
    by("pin").textContent = state.pinned ? "Unpin" : "Pin curve";
    live.update(true);
  });

  if (robot.numbers.planar) by("hold-turn").hidden = false;
  document.querySelectorAll("input[name=hold]").forEach((radio) => radio.addEventListener("change", () => {
    state.hold = radio.value;
    live.lay();
  }));

  by("hertz").addEventListener("change", () => live.setHertz(by("hertz").valueAsNumber));
  for (const id of ["low", "high"]) {
    by(id).addEventListener("change", () => {
      const asked = { low: state.low, high: state.high, [id]: by(id).valueAsNumber };
      if (asked.low >= 0 && asked.high > asked.low && Number.isFinite(asked.high)) Object.assign(state, asked, { pinned: null });
      by("pin").textContent = state.pinned ? "Unpin" : "Pin curve";
      live.update(true);
    });
  }
  by("show-ellipsoid").addEventListener("change", () => live.update(true));

  by("swing-force").addEventListener("click", live.swingForced);
  by("swing-none").addEventListener("click", live.rest);
  by("swing-pause").addEventListener("click", () => { state.playing = !state.playing; live.pressed(); });
  by("amplitude").addEventListener("input", () => { state.amplitude = by("amplitude").valueAsNumber; live.update(true); });
  by("speed").addEventListener("input", () => { state.speed = by("speed").valueAsNumber; });

  by("chart").addEventListener("keydown", (event) => { // a line, or ten with Page; the modes with Enter
    const step = (state.high - state.low) / 399;
    const by_ = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1, PageUp: 10, PageDown: -10 }[event.key];
    const to = { Home: state.low, End: state.high }[event.key];
    if (by_ === undefined && to === undefined) return;
    event.preventDefault();
    live.setHertz(to === undefined ? Math.min(Math.max(state.hertz + by_ * step, state.low), state.high) : to);
  });

  document.querySelectorAll("[data-keep]").forEach((button) => button.addEventListener("click", () => {
    const text = Keep.formats[button.dataset.keep](commanded.map((place) => [joints[place].name, state.q[place]]));
    by("kept").hidden = false;
    by("kept").value = text;
    by("kept").select();
    const said = (words) => { by("kept-says").textContent = words; };
    const copied = navigator.clipboard ? navigator.clipboard.writeText(text) : Promise.reject(new Error("no clipboard"));
    copied.then(() => said("Copied."), () => said("Selected: copy it with Ctrl-C."));
  }));

  if (live.picture) {
    live.picture.draggable(() => live.posed().position("tool"), live.moveTool);
    by("reset-view").addEventListener("click", () => live.picture.reframe());
  }
  new ResizeObserver(() => live.update(true)).observe(by("chart"));

  // A picture has no panel; what must not be missing stands on it.
  if (document.body.classList.contains("picture") && window.flexmodalPage) {
    const words = Panel.make("div", { id: "on-picture" }, ["map-scale", "diagnosis-says", "descent-says"].map(by));
    window.flexmodalPage.stage.append(words);
  }

  const wish = new URLSearchParams(location.hash.slice(1));
  const number = (name) => (wish.has(name) && Number.isFinite(Number(wish.get(name))) ? Number(wish.get(name)) : null);
  for (const part of (wish.get("q") || "").split(",")) {
    const cut = part.lastIndexOf(":");
    const place = joints.findIndex(({ name }) => name === part.slice(0, cut));
    const value = Number(part.slice(cut + 1));
    if (cut > 0 && commanded.includes(place) && Number.isFinite(value)) state.q[place] = Math.min(Math.max(value, joints[place].lower), joints[place].upper);
  }
  live.update();
  live.cells = number("cells") >= 3 && number("cells") <= 60 ? number("cells") : null;
  live.map = WorkspaceMap.make(live);
  if (data.map || number("map") === 1) live.map.lay(live.cells);
  if (data.diagnosis) live.diagnosis = Diagnosed.make(live, data.diagnosis);
  if (data.search) live.film = Film.make(live, data.search);
  if (number("frequency") !== null) { live.setHertz(number("frequency")); live.swingForced(); }
  else if (number("mode") >= 1 && number("mode") <= live.found().modes.length) live.swingIn(number("mode") - 1);
  else if (data.swing === "force") live.swingForced();
  else if (data.swing === "mode" && live.found().modes.length) live.swingIn(0);
  function hold(phase) {
    state.playing = false;
    state.phase = 2 * Math.PI * phase;
    live.pressed();
    live.stand();
  }
  if (window.flexmodalPage) window.flexmodalPage.hold = hold;
  const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
  if (number("phase") !== null) hold(number("phase"));
  else if (still) hold(live.motion() ? live.motion().extreme.phase / (2 * Math.PI) : 0);
  live.pressed();
  live.start();
})();
