"use strict";
// The posture on the page as text that flexmodal and others read.
const Keep = (() => {
  // A name as TOML, JSON and YAML have it between double quotes.
  const quoted = (text) => JSON.stringify(text).replace(/[\u007f-\u009f\u2028\u2029]/g, (letter) => `\\u${letter.charCodeAt(0).toString(16).padStart(4, "0")}`);
  const key = (name) => (/^[A-Za-z0-9_-]+$/.test(name) ? name : quoted(name));
  const number = (value) => (Number.isInteger(value) ? value.toFixed(1) : String(value).replace(/^(-?\d+)e/, "$1.0e"));

  // values: [[joint, value], …] of the commanded joints [rad, m].
  const formats = {
    toml: (values) => ["[posture.kept]", ...values.map(([name, value]) => `${key(name)} = ${number(value)}`)].join("\n") + "\n",
    yaml: (values) => [
      "header:", "  stamp: {sec: 0, nanosec: 0}", "  frame_id: \"\"",
      `name: [${values.map(([name]) => quoted(name)).join(", ")}]`,
      `position: [${values.map(([, value]) => number(value)).join(", ")}]`,
      "velocity: []", "effort: []",
    ].join("\n") + "\n",
    json: (values) => JSON.stringify({ posture: Object.fromEntries(values) }, null, 2) + "\n",
    typed: (values) => values.map(([name, value]) => `${name}=${value}`).join(","),
  };
  return { formats };
})();
