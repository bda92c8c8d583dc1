"use strict";
// A diagnosis gone through: the card, re-tuned, with each effect; at each step its FRFs beside the measured ones,
// the points in the colour of how far the model is from them, and the place that is named.
const Diagnosed = (() => {
  const FARTHEST = 30; // times the noise at which the colour ends
  const LARGER = 1.6; // a point's size there, beside its size at the noise

  function make(live, told) {
    const { by } = Panel;
    const { joints } = live.robot.numbers;
    let stage = 0;
    let number = 0;
    by("diagnosis").hidden = false;
    by("diagnosis-verdict").textContent = told.verdict;

    const body = by("stages").tBodies[0];
    const buttons = told.stages.map(({ name, gap, held }, at) => {
      const button = Panel.make("button", { type: "button", textContent: String(at + 1), ariaLabel: `step ${at + 1}: ${name}` });
      button.addEventListener("click", () => show(at));
      body.append(Panel.make("tr", {}, [
        Panel.make("th", { scope: "row" }, [button, ` ${name}`]),
        Panel.make("td", { textContent: gap }),
        Panel.make("td", { textContent: held || "–" }),
      ]));
      return button;
    });
    body.append(Panel.make("tr", {}, [Panel.make("th", { scope: "row", textContent: "noise floor" }), Panel.make("td", { textContent: told.noise }), Panel.make("td")]));
    by("step-back").addEventListener("click", () => show(Math.max(stage - 1, 0)));
    by("step-on").addEventListener("click", () => show(Math.min(stage + 1, told.stages.length - 1)));
    by("step-pair").hidden = !told.pairs.length;
    Panel.options(by("diagnosis-pair"), told.pairs.map(({ name }, at) => [String(at), name]), "0");
    by("diagnosis-pair").addEventListener("change", () => { number = Number(by("diagnosis-pair").value); stand(); show(stage); });

    // The arm as it stood when this FRF was measured, force and motion as they were.
    function stand() {
      const pair = told.pairs[number];
      if (!pair) return;
      live.state.q = joints.map(({ name }) => pair.q[name] || 0);
      for (const kind of ["response", "reference"]) live.force(kind, pair[kind]);
      live.update();
      if (live.picture) live.picture.reframe(live.picture.tip());
    }

    function curves() {
      const pair = told.pairs[number];
      if (!pair) return [];
      const { response, reference, q, frequencies } = pair;
      const all = { posture: "", q, response, reference, frequencies };
      const before = told.stages[stage - 1];
      const found = [];
      if (before && pair.stages[before.key]) found.push({ ...all, kind: "stage-before", name: `the step before: ${before.name}`, sizes: pair.stages[before.key] });
      const now = told.stages[stage];
      if (pair.stages[now.key]) found.push({ ...all, kind: "stage", name: now.name, sizes: pair.stages[now.key] });
      found.push({ ...all, kind: "measured", name: "measured", sizes: pair.measured });
      return found;
    }

    function colours() {
      if (!live.picture) return;
      const pair = told.pairs[number];
      const here = pair && told.misfit[told.stages[stage].key] ? told.misfit[told.stages[stage].key][pair.posture] : {};
      for (const [path, name] of told.points) {
        const times = here[name];
        const part = times > 1 ? Math.min(Math.log(times) / Math.log(FARTHEST), 1) : 0;
        live.picture.tint(path, Picture.css(part), times === undefined ? 0.7 : 1 + (LARGER - 1) * part);
      }
      told.marks.forEach((paths, at) => paths.forEach((path) => live.picture.see(path, at < told.stages[stage].marks)));
      const far = Object.entries(here).sort((a, b) => b[1] - a[1])[0];
      by("diagnosis-far").textContent = far ? `Farthest in this posture: ${far[0]}, ${Units.plain(far[1], 3)} × the noise.` : "";
    }

    function show(at) {
      stage = at;
      const { name, says, gap, key } = told.stages[at];
      buttons.forEach((button, k) => button.setAttribute("aria-pressed", String(k === at)));
      by("step-back").disabled = at === 0;
      by("step-on").disabled = at === told.stages.length - 1;
      by("diagnosis-says").textContent = `Step ${at + 1} of ${told.stages.length}, ${name}: gap ${gap}. ${says}`;
      const pair = told.pairs[number];
      const bands = pair ? pair.bands[at === told.stages.length - 1 && key === "after" ? "after" : "before"] : [];
      by("diagnosis-bands").replaceChildren(...[...new Set(bands.map(({ says: text }) => text))].map((text) => Panel.make("li", { textContent: text })));
      live.beside(curves(), bands.map(({ band }) => band));
      colours();
    }

    stand();
    show(0);
    if (window.flexmodalPage) window.flexmodalPage.film = (part) => show(Math.round(part * (told.stages.length - 1)));
    return { show, stage: () => stage };
  }

  return { make };
})();
