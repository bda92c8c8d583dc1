"use strict";
// The words and controls beside the picture; names only ever enter as text.
const Panel = (() => {
  const by = (id) => document.getElementById(id);
  function make(name, properties = {}, children = []) {
    const made = Object.assign(document.createElement(name), properties);
    made.append(...children);
    return made;
  }
  const options = (select, values, chosen) => select.replaceChildren(...values.map(([value, text]) => make("option", { value, textContent: text, selected: value === chosen })));

  // A slider for each joint that a posture sets; the others, which only give way, are named with their share.
  function sliders(robot, moved) {
    const rows = robot.numbers.joints.map((joint, place) => {
      const commanded = robot.numbers.commanded.includes(place);
      const id = `joint-${place}`;
      const name = make("label", { htmlFor: id, textContent: joint.name, title: joint.name, className: "name" });
      const value = make("output", { className: "value" });
      value.htmlFor.add(id);
      const share = make("span", { className: "share" });
      const range = make("input", { type: "range", id, min: joint.lower, max: joint.upper, step: "any", hidden: !commanded });
      range.addEventListener("input", () => moved(place, Number(range.value)));
      range.addEventListener("keydown", (event) => { // step "any" leaves keys to us: a degree, or ten with Shift
        const sense = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1, PageUp: 10, PageDown: -10 }[event.key];
        if (sense === undefined) return;
        event.preventDefault();
        const step = (joint.turns ? Math.PI / 180 : 1e-3) * sense * (event.shiftKey ? 10 : 1);
        moved(place, Math.min(Math.max(Number(range.value) + step, joint.lower), joint.upper));
      });
      const middle = commanded ? range : make("span", { className: "note", textContent: "gives way only" });
      by("sliders").append(make("div", { className: "joint" }, [name, middle, value, share]));
      return { range, value, share, joint, commanded };
    });
    return {
      show(q, shares) {
        rows.forEach(({ range, value, share, joint, commanded }, place) => {
          const text = Units.joint(q[place], joint.turns);
          if (commanded) {
            range.value = q[place];
            range.setAttribute("aria-valuetext", text);
            value.textContent = text;
          }
          const flexible = robot.numbers.flexible.indexOf(place);
          const part = shares && flexible >= 0 ? shares[flexible] : null;
          share.textContent = part === null ? "" : Units.percent(part);
          share.title = part === null ? "" : "share of the elastic energy";
          share.style.setProperty("--part", part === null ? 0 : part);
          share.style.setProperty("--colour", part === null ? "transparent" : Picture.css(part));
        });
      },
    };
  }

  function place(moved) {
    const boxes = ["x", "y", "z"].map((axis, number) => {
      const box = make("input", { type: "number", step: "0.01" });
      box.addEventListener("change", () => { if (Number.isFinite(box.valueAsNumber)) moved(number, box.valueAsNumber); });
      by("place").append(make("label", {}, [`${axis} `, box]));
      return box;
    });
    by("place").append(" m");
    return { show: (p) => boxes.forEach((box, k) => { if (document.activeElement !== box) box.value = (Math.round(p[k] * 1e4) / 1e4 + 0).toString(); }) };
  }

  function modes(chosen) {
    const body = by("modes").tBodies[0];
    let buttons = [];
    return {
      buttons: () => buttons,
      show(found, active) {
        if (buttons.length !== found.length) {
          buttons = found.map((_, number) => {
            const button = make("button", { type: "button", textContent: String(number + 1) });
            button.addEventListener("click", () => chosen(number));
            return button;
          });
          body.replaceChildren(...buttons.map((button) => make("tr", {}, [make("th", { scope: "row" }, [button]), make("td"), make("td")])));
        }
        found.forEach((mode, number) => {
          const [, frequency, damping] = body.rows[number].cells;
          frequency.textContent = `${Units.plain(Modes.frequency(mode))} Hz`;
          damping.textContent = mode.pole[1] === 0 ? "overdamped" : `${Units.plain(100 * Modes.ratio(mode), 3)} %`;
          buttons[number].setAttribute("aria-pressed", String(number === active));
          buttons[number].setAttribute("aria-label", `swing in mode ${number + 1}`);
        });
      },
    };
  }

  function directions(robot, kind, text, changed) {
    const [point, axis] = [by(kind), by(`${kind}-axis`)];
    const cut = text.lastIndexOf(":");
    options(point, Object.keys(robot.numbers.points).map((name) => [name, name]), text.slice(0, cut));
    const axes = ["+x", "+y", "+z", "-x", "-y", "-z", "+rx", "+ry", "+rz"];
    const given = text.slice(cut + 1);
    options(axis, [...new Set([given, ...axes])].map((name) => [name, name.replace("-", "−")]), given);
    for (const select of [point, axis]) select.addEventListener("change", () => changed(`${point.value}:${axis.value}`));
  }

  // What such a pair of lists has chosen, said from outside.
  function choose(kind, text) {
    const cut = text.lastIndexOf(":");
    const axis = by(`${kind}-axis`);
    const given = text.slice(cut + 1);
    if (![...axis.options].some(({ value }) => value === given)) axis.append(make("option", { value: given, textContent: given.replace("-", "−") }));
    by(kind).value = text.slice(0, cut);
    axis.value = given;
  }

  return { by, make, choose, options, sliders, place, modes, directions };
})();
