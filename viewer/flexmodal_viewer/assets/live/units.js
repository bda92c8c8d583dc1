"use strict";
// Numbers as people read them; the same rules as flexmodal_viewer/units.py.
const Units = (() => {
  const PREFIXES = { "-12": "p", "-9": "n", "-6": "µ", "-3": "m", 0: "", 3: "k", 6: "M" };
  const RAISED = { "-": "⁻", 0: "⁰", 1: "¹", 2: "²", 3: "³", 4: "⁴", 5: "⁵", 6: "⁶", 7: "⁷", 8: "⁸", 9: "⁹" };
  const sign = (text) => text.replace("-", "−");
  const raised = (power) => [...String(power)].map((letter) => RAISED[letter]).join("");

  function plain(value, digits = 4) {
    if (!Number.isFinite(value)) return "–";
    const size = Math.abs(value);
    if (size !== 0 && (size < 1e-4 || size >= 10 ** digits)) {
      const [factor, power] = value.toExponential(digits - 1).split("e");
      return sign(`${Number(factor)} × 10${raised(Number(power))}`);
    }
    return sign(String(Number(value.toPrecision(digits))));
  }

  // Such as "12.3 µm/N".
  function quantity(value, unit) {
    if (!Number.isFinite(value) || value === 0 || unit.startsWith("m²")) return `${plain(value)} ${unit}`;
    const power = Math.min(Math.max(3 * Math.floor(Math.log10(Math.abs(value)) / 3 + 1e-9), -12), 6);
    return sign(`${Number((value / 10 ** power).toPrecision(4))} ${PREFIXES[power]}${unit}`);
  }

  const degrees = (value, digits = 1) => {
    const text = ((value * 180) / Math.PI).toFixed(digits);
    return sign(Number(text) === 0 ? Number(0).toFixed(digits) : text) + "°";
  };
  const joint = (value, turns) => (turns ? degrees(value) : sign((1e3 * value).toFixed(1)) + " mm");
  const percent = (part) => `${Math.round(100 * part)} %`;
  const receptance = (response, reference) => `${response ? "rad" : "m"}/${reference ? "(N·m)" : "N"}`;

  return { plain, quantity, degrees, joint, percent, raised, receptance };
})();
