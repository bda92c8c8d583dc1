"use strict";
// The live view: one posture, one force, one frequency; whatever is moved, all else follows at once.
const Live = (() => {
  const LINES = 400;
  const { by } = Panel;

  function make(data) {
    const robot = Robot.make(data.robot);
    const others = data.others.map((other) => ({ name: other.name, robot: Robot.make(other.robot) }));
    const { joints, commanded, flexible } = robot.numbers;
    const page = window.flexmodalPage || null;
    const picture = Picture.make(page, robot, data.reach);
    const state = {
      q: joints.map(({ name }) => data.posture[name] || 0),
      response: robot.direction(data.response), reference: robot.direction(data.response),
      names: { response: data.response, reference: data.response },
      low: data.band[0], high: data.band[1], hertz: data.hertz,
      swing: null, phase: 0, playing: true, amplitude: 1, speed: 1, hold: "free", pinned: null,
    };
    let posed = robot.at(state.q);
    let found = { modes: [], value: [0, 0] };
    let motion = null;

    const unit = () => Units.receptance(state.response.row > 2, state.reference.row > 2);
    const frequencies = () => Float64Array.from({ length: LINES }, (_, i) => state.low + ((state.high - state.low) * i) / (LINES - 1));
    const sizes = ({ re, im }) => Array.from(re, (x, i) => Math.hypot(x, im[i]));
    const value = (at) => at.frf([state.hertz], state.response, state.reference);
    const size = (at) => { const h = value(at); return Math.hypot(h.re[0], h.im[0]); };
    const judge = data.search && data.search.objective ? Objective.make(robot, data.search.objective) : null;
    const bySearch = () => judge !== null && by("judge").value === "search";
    const objective = (at) => (bySearch() ? judge(at) : size(at)); // along the self-motion

    // Another model stands in the same posture, joint by joint; what it does not have stays at 0.
    function other(model) {
      const q = model.numbers.joints.map(({ name }) => { const at = joints.findIndex((joint) => joint.name === name); return at < 0 ? 0 : state.q[at]; });
      const [response, reference] = [model.direction(state.names.response), model.direction(state.names.reference)];
      return response && reference ? { at: model.at(q), response, reference } : null;
    }

    const chart = Chart.make(by("chart"), (hertz, mode) => {
      if (mode !== null && mode < found.modes.length) swingIn(mode);
      else { setHertz(hertz); swingForced(); }
    });
    const sliders = Panel.sliders(robot, moveJoint);
    const place = Panel.place((axis, metres) => {
      const target = posed.position("tool");
      target[axis] = metres;
      moveTool(target);
    });
    const table = Panel.modes((mode) => (state.swing && state.swing.mode === mode ? rest() : swingIn(mode)));
    const motionOf = SelfMotion.make({ robot, value: objective, text: (found) => Units.quantity(found, bySearch() ? data.search.unit : unit()), larger: () => bySearch() && data.search.large, name: () => (bySearch() ? "The search's objective" : "|α|"), go: (q) => { state.q = q; update(true); } });

    // Of a served page Python's numbers are drawn as soon as they are there, and how far the page's are from them is said.
    const python = Python.connect(({ re, im, poles }) => {
      const own = found.curve;
      if (own.re.length !== re.length) return;
      let [off, most] = [0, 0];
      re.forEach((x, i) => {
        off = Math.max(off, Math.hypot(x - own.re[i], im[i] - own.im[i]));
        most = Math.max(most, Math.hypot(x, im[i]));
      });
      state.python = { off: most > 0 ? off / most : 0, poles };
      found.curve = { re: Float64Array.from(re), im: Float64Array.from(im) };
      plot();
      by("python-says").textContent = `Python's curve; the page's own is within ${Units.plain(state.python.off, 1)} of it.`;
    }, (text) => { by("python-says").textContent = text; });

    // Everything that follows from the posture, the force and the frequency.
    function update(keepWay = false) {
      posed = robot.at(state.q);
      const lines = frequencies();
      const curve = posed.frf(lines, state.response, state.reference);
      const here = value(posed);
      found = { modes: posed.modes() || [], value: [here.re[0], here.im[0]], curve, lines };
      plot();
      reswing();
      words();
      if (!keepWay) lay();
      const strange = [state.response, state.reference].some(({ point }) => robot.numbers.points[point].tested);
      if (python && strange) by("python-says").textContent = "The page's own curve: a point of the campaign.";
      if (python && !strange) {
        const q = Object.fromEntries(commanded.map((place) => [joints[place].name, state.q[place]]));
        python.ask({ q, low: state.low, high: state.high, lines: LINES, ...state.names });
      }
      watchers.forEach((told) => told());
    }
    const watchers = []; // told whenever something has moved
    function go(q) { state.q = [...q]; update(); }

    function plot() {
      const { curve, lines } = found;
      const series = [{ name: "live", kind: "live", sizes: sizes(curve), at: Math.hypot(...found.value) }];
      if (state.pinned) series.push({ name: "pinned", kind: "pinned", sizes: state.pinned });
      others.forEach(({ name, robot: model }, number) => {
        const stands = other(model);
        if (stands) series.push({ name: `other ${number}: ${name}`, kind: `other-${number}`, sizes: sizes(stands.at.frf(lines, stands.response, stands.reference)) });
      });
      for (const one of [...data.measured, ...extra.curves]) {
        if (!fits(one)) continue;
        const kind = one.kind || "measured";
        let name = `${kind}: ${one.name}`;
        while (series.some((taken) => taken.name === name)) name += "′"; // repeats
        series.push({ name, kind, sizes: one.sizes, frequencies: one.frequencies });
      }
      legend(series);
      chart.draw({
        frequencies: lines, series, hertz: state.hertz, unit: unit(), bands: series.some(({ kind }) => kind === "measured") ? extra.bands : [],
        modes: found.modes.map((mode, number) => ({ hertz: Modes.frequency(mode), name: String(number + 1), chosen: state.swing !== null && state.swing.mode === number })),
      });
    }

    // More curves [{ kind, name, q, response, reference, frequencies, sizes }] for the postures they belong to, and
    // bands [Hz] to be shaded with them.
    let extra = { curves: [], bands: [] };
    function beside(curves, bands) { extra = { curves, bands }; update(); }

    // Where the force acts, or the motion is looked at ("reference", "response"), such as "tool:+z".
    function force(kind, text) {
      state[kind] = robot.direction(text);
      state.names[kind] = text;
      Panel.choose(kind, text);
    }

    // Measured where the arm stands now, between the points and axes chosen; the senses do not change a size.
    const place_ = (text) => text.replace(/:[+-]?/, ":");
    const fits = (one) => place_(one.response) === place_(state.names.response) && place_(one.reference) === place_(state.names.reference)
      && joints.every(({ name }, k) => Math.abs((one.q[name] || 0) - state.q[k]) < 1e-6);

    function legend(series) {
      const kinds = new Map(series.map(({ name, kind }) => [kind, name.replace(/^(other \d+|measured|stage|stage-before): /, "")]));
      kinds.set("live", robot.numbers.name);
      if (kinds.has("pinned")) kinds.set("pinned", "pinned");
      const key = JSON.stringify([...kinds]);
      if (by("curve-legend").dataset.key === key) return;
      by("curve-legend").dataset.key = key;
      by("curve-legend").replaceChildren(...(kinds.size < 2 ? [] : [...kinds].map(([kind, text]) => {
        const line = Panel.make("li");
        const swatch = Chart.element(line, "svg", { width: 30, height: 10, "aria-hidden": "true" });
        Chart.element(swatch, "path", { class: `curve ${kind}`, d: "M0 5H30" });
        line.append(Panel.make("span", { textContent: text }));
        return line;
      })));
    }

    function words() {
      const mode = state.swing && state.swing.mode !== undefined ? state.swing.mode : null;
      sliders.show(state.q, motion ? motion.shares : null);
      place.show(posed.position("tool"));
      table.show(found.modes, mode);
      const [re, im] = found.value;
      const ellipsoid = posed.ellipsoid("tool", state.hertz);
      const axes = ellipsoid ? `; half axes of the ellipsoid ${ellipsoid.lengths.map((length) => Units.quantity(length, "m/N")).join(", ")}` : "";
      by("readout").textContent = `|α| at ${Units.plain(state.hertz)} Hz: ${Units.quantity(Math.hypot(re, im), unit())}, phase ${Units.degrees(Math.atan2(im, re))}${axes}`;
      const own = [...new Set([state.reference.point, state.response.point])].filter((name) => robot.numbers.points[name].axes);
      by("axes-say").textContent = own.map((name) => `x, y, z at ${name}: ${robot.numbers.points[name].axes.says}.`).join(" ");
      by("chart").setAttribute("aria-valuenow", state.hertz);
      by("chart").setAttribute("aria-valuemin", state.low);
      by("chart").setAttribute("aria-valuemax", state.high);
      by("chart").setAttribute("aria-valuetext", `${Units.plain(state.hertz)} hertz, ${Units.quantity(Math.hypot(re, im), unit())}`);
      for (const [id, number] of [["hertz", state.hertz], ["low", state.low], ["high", state.high]]) {
        if (document.activeElement !== by(id)) by(id).value = Number(number.toPrecision(6));
      }
      draw(ellipsoid);
    }

    function draw(ellipsoid) {
      if (!picture) return;
      picture.arm("rest", posed.placed);
      picture.place("handle", posed.position("tool"));
      picture.arrow(state.reference, posed.along(state.reference), posed.position(state.reference.point));
      picture.ellipsoid(by("show-ellipsoid").checked ? ellipsoid : null, posed.position("tool"));
      picture.show("rest", motion !== null);
      stand();
    }

    // The arm as it stands at this phase of its swing, or at rest.
    function stand() {
      if (!picture) return;
      const q = motion ? Swing.joints(robot, state.q, motion.shape, motion.scale * state.amplitude, state.phase) : state.q;
      const placed = motion ? Chain.frames(joints, q) : posed.placed;
      picture.arm("arm", placed);
      picture.rings(placed, motion ? motion.shares : null);
      picture.dirty();
    }

    function reswing() {
      motion = null;
      if (state.swing === null) { says(""); return; }
      const { mode } = state.swing;
      if (mode !== undefined && mode >= found.modes.length) { state.swing = null; return; }
      const raw = mode === undefined ? posed.deflection(state.reference, state.hertz) : Swing.straight(found.modes[mode].shape);
      if (raw === null) { says("An undamped mode is driven at its own frequency: the motion grows without bound."); return; }
      const rows = [0, 1, 2].map((axis) => posed.row({ point: "tool", row: axis, sign: 1 }));
      const factor = Swing.scale(robot, rows, raw, data.reach);
      if (!raw.re.some(Boolean) && !raw.im.some(Boolean)) { says("This force moves nothing in this posture."); return; }
      motion = { shape: raw, scale: factor, shares: posed.shares(raw), extreme: Swing.farthest(rows, raw) };
      const drawn = factor * state.amplitude;
      if (mode === undefined) says(`Operating deflection at ${Units.plain(state.hertz)} Hz: the tool goes ${Units.quantity(motion.extreme.length, "m")} per ${state.reference.row > 2 ? "N·m" : "N"}, drawn × ${Units.plain(drawn, 3)} and slowed down.`);
      else says(`Mode ${mode + 1}, ${Units.plain(Modes.frequency(found.modes[mode]))} Hz: a mode has a shape and no size; slowed down.`);
    }
    const says = (text) => { if (by("swing-says").textContent !== text) by("swing-says").textContent = text; };

    function pressed() {
      by("swing-force").setAttribute("aria-pressed", String(state.swing !== null && state.swing.mode === undefined));
      by("swing-none").setAttribute("aria-pressed", String(state.swing === null));
      by("swing-pause").hidden = state.swing === null;
      by("swing-pause").textContent = state.playing ? "Pause" : "Play";
    }
    function swingIn(mode) {
      state.swing = { mode };
      setHertz(Modes.frequency(found.modes[mode]));
    }
    function swingForced() { state.swing = {}; pressed(); update(true); }
    function rest() { state.swing = null; state.phase = 0; pressed(); update(true); }
    function setHertz(hertz) {
      if (!(hertz >= 0) || !Number.isFinite(hertz)) return;
      state.hertz = hertz;
      if (picture) picture.rescale();
      pressed();
      update();
    }

    function moveJoint(number, to) {
      if (state.hold === "free") {
        state.q[number] = to;
      } else { // the others follow, so that the tool stays
        const turned = state.hold === "turn";
        const target = { position: posed.position("tool"), turn: turned ? posed.turned("tool") : null };
        const next = [...state.q];
        next[number] = to;
        const met = Hold.reach(robot, next, "tool", target, { rounds: 25, damping: 0, without: [number] });
        if (met.left > 1e-7) { sliders.show(state.q, motion ? motion.shares : null); return; } // as far as it goes
        state.q = met.q;
      }
      update();
    }
    function moveTool(position) {
      const turned = state.hold === "turn";
      state.q = Hold.reach(robot, state.q, "tool", { position, turn: turned ? posed.turned("tool") : null }).q;
      update();
    }

    by("judge").closest(".line").hidden = judge === null;
    by("judge").addEventListener("change", () => lay());
    let waiting = 0;
    function lay() {
      clearTimeout(waiting);
      if (state.hold === "free") { motionOf.hide(); return; }
      waiting = setTimeout(() => motionOf.lay(state.q, "tool", state.hold === "turn"), 120);
    }

    let before = null;
    function turnOver(now) {
      if (motion && state.playing && before !== null) {
        state.phase = (state.phase + ((now - before) / 1000 / Swing.CYCLE) * 2 * Math.PI * state.speed) % (2 * Math.PI);
        stand();
      }
      before = now;
      requestAnimationFrame(turnOver);
    }

    return {
      robot, others, state, picture, hold: Hold, make: Robot.make, judge: Objective.make, found: () => found, posed: () => posed, motion: () => motion, motionOf,
      update, go, watch: (told) => watchers.push(told), beside, force, objective, size, unit, reach: data.reach, stand, swingIn, swingForced, rest, setHertz, moveJoint, moveTool, pressed, lay, flexible, commanded,
      start: () => requestAnimationFrame(turnOver),
    };
  }

  return { make };
})();
