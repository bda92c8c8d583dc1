"use strict";
// Curves over a frequency axis in an SVG: a logarithm of sizes upwards, a line for the frequency chosen, modes on top.
const Chart = (() => {
  const NS = "http://www.w3.org/2000/svg";
  const PAD = { left: 58, right: 14, top: 38, bottom: 34 };

  function element(parent, name, attributes = {}, text = null) {
    const made = document.createElementNS(NS, name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    if (text !== null) made.textContent = text;
    parent.appendChild(made);
    return made;
  }

  const step = (length, most) => {
    const rough = length / most;
    const power = 10 ** Math.floor(Math.log10(rough));
    return [1, 2, 5, 10].map((factor) => factor * power).find((value) => value >= rough * (1 - 1e-9));
  };

  // `choose(hertz, mode)` is told where somebody clicked; mode is the number of a peak clicked, or null.
  function make(svg, choose) {
    const grid = element(svg, "g", { class: "grid" });
    const clip = element(element(svg, "defs"), "clipPath", { id: "plot" });
    const window_ = element(clip, "rect");
    const shades = element(svg, "g", { "clip-path": "url(#plot)" });
    const curves = element(svg, "g", { "clip-path": "url(#plot)" });
    const tops = element(svg, "g");
    const cursor = element(svg, "g", { class: "cursor" });
    const line = element(cursor, "line");
    const dot = element(cursor, "circle", { r: 4.5 });
    const paths = new Map();
    let view = null;
    let laid = "";

    const x = (hertz) => PAD.left + ((hertz - view.low) / (view.high - view.low)) * view.width;
    const y = (size) => PAD.top + ((view.top - Math.log10(size)) / (view.top - view.bottom)) * view.height;

    function range(series, first, last) {
      let low = Infinity;
      let high = -Infinity;
      for (const { sizes, frequencies } of series) {
        for (let i = 0; i < sizes.length; i++) {
          const size = sizes[i];
          if (frequencies && (frequencies[i] < first || frequencies[i] > last)) continue;
          if (size > 0 && size < low) low = size;
          if (size > high && size < Infinity) high = size;
        }
      }
      if (!(high > 0)) return [-9, -3];
      let [bottom, top] = [Math.log10(Math.max(low, high * 1e-6)), Math.log10(high)];
      if (view && view.kept && top <= view.top && bottom >= view.bottom && view.top - view.bottom < 2.5 * (top - bottom) + 1) return [view.bottom, view.top];
      bottom = Math.floor(bottom * 2 - 0.2) / 2; // half a decade at a time, so that the axis stays while a joint moves
      top = Math.ceil(top * 2 + 0.2) / 2;
      return [bottom, top];
    }

    // data: { frequencies, series: [{ name, kind, sizes, frequencies of its own }], modes: [{ hertz, name }], hertz, unit, log }
    function draw(data) {
      const box = svg.getBoundingClientRect();
      const width = Math.max(box.width - PAD.left - PAD.right, 40);
      const height = Math.max(box.height - PAD.top - PAD.bottom, 40);
      const { frequencies } = data;
      const [bottom, top] = range(data.series, data.frequencies[0], data.frequencies[data.frequencies.length - 1]);
      const low = frequencies[0];
      const high = frequencies[frequencies.length - 1];
      const same = view && [width, height, bottom, top, low, high, data.unit].every((value, i) => value === view.key[i]);
      view = { width, height, bottom, top, low, high, kept: true, key: [width, height, bottom, top, low, high, data.unit] };
      if (!same) axes(data.unit);
      for (const one of data.series) {
        if (!paths.has(one.name)) paths.set(one.name, element(curves, "path", { class: `curve ${one.kind}` }));
        let text = "";
        let pen = "M";
        const lines = one.frequencies || frequencies; // what was measured has lines of its own
        for (let i = 0; i < lines.length; i++) {
          if (!(one.sizes[i] > 0) || one.sizes[i] === Infinity) { pen = "M"; continue; }
          text += `${pen}${x(lines[i]).toFixed(1)} ${y(one.sizes[i]).toFixed(1)}`;
          pen = "L";
        }
        paths.get(one.name).setAttribute("d", text);
      }
      for (const [name, path] of paths) {
        if (!data.series.some((one) => one.name === name)) { path.remove(); paths.delete(name); }
      }
      const order = data.series.map(({ name }) => name).join("\n"); // the last lies on top
      if (order !== laid) { data.series.forEach(({ name }) => curves.append(paths.get(name))); laid = order; }
      shades.replaceChildren();
      for (const [first, last] of data.bands || []) element(shades, "rect", { class: "band", x: x(first), y: PAD.top, width: Math.max(x(last) - x(first), 1), height });
      marks(data.modes);
      point(data);
    }

    function axes(unit) {
      grid.replaceChildren();
      const { width, height, bottom, top, low, high } = view;
      for (const [key, value] of Object.entries({ x: PAD.left, y: PAD.top, width, height })) window_.setAttribute(key, value);
      const by = step(high - low, Math.max(3, Math.floor(width / 70)));
      for (let hertz = Math.ceil(low / by - 1e-9) * by; hertz <= high * (1 + 1e-9); hertz += by) {
        element(grid, "line", { x1: x(hertz), x2: x(hertz), y1: PAD.top, y2: PAD.top + height });
        element(grid, "text", { x: x(hertz), y: PAD.top + height + 15, "text-anchor": "middle" }, Units.plain(Number(hertz.toPrecision(6))));
      }
      const every = Math.max(1, Math.ceil(((top - bottom) * 20) / height));
      for (let power = Math.ceil(bottom); power <= top; power += 1) {
        element(grid, "line", { x1: PAD.left, x2: PAD.left + width, y1: y(10 ** power), y2: y(10 ** power) });
        if (power % every === 0) element(grid, "text", { x: PAD.left - 6, y: y(10 ** power) + 4, "text-anchor": "end" }, `10${Units.raised(power)}`);
      }
      element(grid, "rect", { x: PAD.left, y: PAD.top, width, height, class: "frame" });
      element(grid, "text", { x: PAD.left + width, y: PAD.top + height + 30, "text-anchor": "end" }, "frequency [Hz]");
      element(grid, "text", { x: PAD.left, y: PAD.top + height + 30 }, `|α| [${unit}]`);
    }

    function marks(modes) {
      tops.replaceChildren();
      const last = [-Infinity, -Infinity, -Infinity]; // right ends of the numbers that stand in three rows
      for (const mode of modes) {
        if (mode.hertz < view.low || mode.hertz > view.high) continue;
        const at = x(mode.hertz);
        const row = Math.max(0, last.findIndex((end) => at - end > 11));
        last[row] = at;
        element(tops, "path", { class: `peak${mode.chosen ? " chosen" : ""}`, d: `M${at.toFixed(1)} ${PAD.top}l-4 -7h8z` });
        element(tops, "text", { class: "peak", x: at.toFixed(1), y: PAD.top - 9 - 10 * row, "text-anchor": "middle" }, mode.name);
      }
    }

    function point({ series, hertz }) {
      const inside = hertz >= view.low && hertz <= view.high;
      cursor.style.display = inside ? "" : "none";
      if (!inside) return;
      const at = x(hertz);
      for (const [key, value] of Object.entries({ x1: at, x2: at, y1: PAD.top, y2: PAD.top + view.height })) line.setAttribute(key, value);
      const size = series[0].at;
      dot.style.display = size > 0 && size < Infinity ? "" : "none";
      if (size > 0 && size < Infinity) { dot.setAttribute("cx", at); dot.setAttribute("cy", y(size)); }
    }

    let modes = [];
    function pick(event, peaks) {
      const box = svg.getBoundingClientRect();
      const at = event.clientX - box.left;
      const hertz = view.low + ((at - PAD.left) / view.width) * (view.high - view.low);
      if (hertz < view.low || hertz > view.high) return;
      const near = peaks ? modes.map((mode, number) => ({ number, away: Math.abs(x(mode.hertz) - at) })).sort((a, b) => a.away - b.away)[0] : undefined;
      choose(hertz, near !== undefined && near.away < 7 ? near.number : null);
    }
    svg.addEventListener("pointerdown", (event) => {
      if (view === null || event.button !== 0) return;
      pick(event, true);
      svg.setPointerCapture(event.pointerId);
    });
    svg.addEventListener("pointermove", (event) => {
      if (view !== null && svg.hasPointerCapture(event.pointerId) && Math.abs(event.movementX) > 0) pick(event, false);
    });

    return { draw: (data) => { modes = data.modes; draw(data); } };
  }

  return { make, element };
})();
