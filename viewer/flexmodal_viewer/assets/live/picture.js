"use strict";
// The arm in meshcat's scene: links, ghost, rings at the joints, arrow, ellipsoid, and the tool under the pointer.
const Picture = (() => {
  const SIZE = 0.18; // of the ellipsoid's longest half axis when its size is set, as a part of the reach
  // From grey to vermilion, darker and stronger the larger the share; told apart without colour too, by the size.
  const RAMP = [[0, [0x9a, 0xa3, 0xad]], [0.33, [0xe6, 0x9f, 0x00]], [1, [0xd5, 0x5e, 0x00]]];

  function colour(share) {
    const upper = Math.max(1, RAMP.findIndex(([at]) => at >= share));
    const [[a, first], [b, second]] = [RAMP[upper - 1], RAMP[upper]];
    const t = Math.min(Math.max((share - a) / (b - a), 0), 1);
    return first.map((value, k) => Math.round(value + t * (second[k] - value)));
  }
  const css = (share) => `rgb(${colour(share).join(", ")})`;

  // Columns of a homogeneous matrix, as three.js has them.
  const matrix = (r, p) => [r[0], r[3], r[6], 0, r[1], r[4], r[7], 0, r[2], r[5], r[8], 0, p[0], p[1], p[2], 1];
  function along(axis) { // rotation whose z is the axis
    const helper = [0, 0, 0];
    helper[axis.map(Math.abs).indexOf(Math.min(...axis.map(Math.abs)))] = 1;
    let across = Chain.cross(helper, axis);
    across = Chain.times(1 / Math.hypot(...across), across);
    return Chain.transpose([...across, ...Chain.cross(axis, across), ...axis]);
  }

  function make(page, robot, reach) {
    if (!page) return null; // no WebGL: the numbers work without the picture
    const { viewer, node } = page;
    const THREE = MeshCat.THREE;
    const links = robot.numbers.links.map(({ joint, place }, number) => ({ joint, place: new THREE.Matrix4().fromArray(place), number }));
    const set = (path, values) => viewer.set_transform(["flexmodal", ...path.split("/")], values);
    const show = (path, visible) => { node(`/flexmodal/${path}`).visible = visible; viewer.set_dirty(); };
    let unit = null; // metres in the picture for each m/N

    function arm(group, placed) {
      for (const { joint, place, number } of links) {
        if (joint < 0) continue;
        const at = new THREE.Matrix4().fromArray(matrix(placed[joint].r, placed[joint].p)).multiply(place);
        set(`${group}/link_${number}`, at.toArray());
      }
    }
    function rings(placed, shares) {
      robot.numbers.flexible.forEach((place, i) => {
        const share = shares ? shares[i] : 0;
        const size = 1 + 0.9 * share;
        const { axis, p } = placed[place];
        set(`ring_${i}`, matrix(along(axis).map((value) => value * size), p));
        node(`/flexmodal/ring_${i}`).traverse((object) => {
          if (object.material) object.material.color.set(css(share));
        });
      });
    }
    function arrow(direction, axis, position) { // along or about that vector
      const kinds = { force_0: direction.row < 3, force_1: direction.row >= 3 };
      for (const [path, shown] of Object.entries(kinds)) {
        set(path, matrix(along(axis), position));
        show(path, shown);
      }
    }
    function ellipsoid(found, position) {
      show("ellipsoid", found !== null);
      if (found === null) return;
      const longest = found.lengths[2];
      if (unit === null && longest > 0) unit = (SIZE * reach) / longest;
      const lengths = found.lengths.map((length) => Math.max(Math.min(length * (unit || 0), 4 * SIZE * reach), 0.004 * reach));
      const columns = found.axes.map((axis, k) => Chain.times(lengths[k], axis));
      set("ellipsoid", matrix(Chain.transpose(columns.flat()), position));
    }

    // Where a point of the world stands in the window, and the point at the same depth under another place there.
    const world = (p) => new THREE.Vector3(p[0], p[2], -p[1]);
    function project(p) {
      const seen = world(p).project(viewer.camera);
      const box = page.stage.getBoundingClientRect();
      return { x: box.left + ((seen.x + 1) / 2) * box.width, y: box.top + ((1 - seen.y) / 2) * box.height, z: seen.z };
    }
    function lift(x, y, z) {
      const box = page.stage.getBoundingClientRect();
      const p = new THREE.Vector3((2 * (x - box.left)) / box.width - 1, 1 - (2 * (y - box.top)) / box.height, z).unproject(viewer.camera);
      return [p.x, -p.z, p.y];
    }

    // The tool taken by the pointer; `where()` says where it is, `moved(p)` is told where it should go.
    function draggable(where, moved) {
      let depth = null;
      const near = (event) => {
        const at = project(where());
        return Math.hypot(event.clientX - at.x, event.clientY - at.y) < (event.pointerType === "mouse" ? 16 : 30) ? at : null;
      };
      page.stage.addEventListener("pointerdown", (event) => {
        const at = near(event);
        if (at === null || event.button !== 0) return;
        depth = at.z;
        page.stage.setPointerCapture(event.pointerId);
        event.stopPropagation();
        event.preventDefault();
      }, true);
      page.stage.addEventListener("pointermove", (event) => {
        if (depth !== null) { moved(lift(event.clientX, event.clientY, depth)); event.stopPropagation(); return; }
        page.stage.style.cursor = near(event) ? "grab" : "";
      }, true);
      for (const kind of ["pointerup", "pointercancel"]) {
        page.stage.addEventListener(kind, (event) => { if (depth !== null) event.stopPropagation(); depth = null; }, true);
      }
    }

    function reframe(more = []) { // the arm, and other points of the world
      const box = new THREE.Box3().setFromObject(node("/flexmodal/arm"));
      const corners = [...more];
      for (const x of [box.min.x, box.max.x]) for (const y of [box.min.y, box.max.y]) for (const z of [box.min.z, box.max.z]) corners.push([x, -z, y]);
      page.frame(corners);
    }

    // The end of the force's arrow, as a list of one point.
    const ARROW = 0.18;
    function tip() {
      const at = node("/flexmodal/force_0");
      at.updateMatrix();
      const p = new THREE.Vector3(0, 0, ARROW * reach).applyMatrix4(at.matrix);
      return [[p.x, p.y, p.z]];
    }

    function tint(path, colour, size) { // a thing by its whole path
      const at = node(`${path}/<object>`); // in its own place; the node above has that of the link
      at.scale.setScalar(size);
      at.traverse((object) => { if (object.material) object.material.color.set(colour); });
      viewer.set_dirty();
    }

    return {
      tint, tip,
      see: (path, visible) => { node(path).visible = visible; viewer.set_dirty(); },
      arm, rings, arrow, ellipsoid, show, draggable, project, reframe,
      place: (path, p) => set(path, matrix([1, 0, 0, 0, 1, 0, 0, 0, 1], p)),
      rescale: () => { unit = null; },
      scale: () => unit,
      dirty: () => { page.hurry(); viewer.set_dirty(); },
    };
  }

  return { make, css };
})();
