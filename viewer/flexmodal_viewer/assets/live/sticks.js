"use strict";
// Many postures at once as thin sticks from joint to joint, each in a colour: one thing to draw for all of them.
const Sticks = (() => {
  const THICK = 0.006; // across, as a part of the reach

  function make(page, robot, reach, count) {
    const THREE = MeshCat.THREE;
    const { joints, points } = robot.numbers;
    const parents = [...joints.map(({ parent }) => parent), points.tool.joint];
    const group = page.node("/flexmodal/sticks");
    const stick = new THREE.CylinderGeometry(THICK * reach, THICK * reach, 1, 6, 1, true);
    const drawn = new THREE.InstancedMesh(stick, new THREE.MeshBasicMaterial(), count * parents.length);
    drawn.frustumCulled = false;
    group.visible = false;
    group.clear();
    group.add(drawn);
    const [from, way, up] = [new THREE.Vector3(), new THREE.Vector3(), new THREE.Vector3(0, 1, 0)];
    const [matrix, turn] = [new THREE.Matrix4(), new THREE.Quaternion()];
    const colour = new THREE.Color();
    for (let k = 0; k < drawn.count; k++) drawn.setColorAt(k, colour); // there before the shader is made

    // postures: joint values of each; parts: from 0 to 1, for its colour; `skip` is not drawn.
    function show(postures, parts, skip) {
      postures.forEach((q, number) => {
        const placed = Chain.frames(joints, q);
        const ends = [...placed.map(({ p }) => p), Chain.position(placed, points.tool)];
        colour.setRGB(...Colours.at(parts[number]).map((value) => value / 255));
        ends.forEach((end, k) => {
          const begin = parents[k] < 0 ? [0, 0, 0] : ends[parents[k]];
          from.set(...begin);
          way.set(...end).sub(from);
          const length = number === skip ? 0 : way.length();
          turn.setFromUnitVectors(up, way.normalize());
          matrix.compose(from.addScaledVector(way, length / 2), turn, new THREE.Vector3(length > 0 ? 1 : 0, length, length > 0 ? 1 : 0));
          drawn.setMatrixAt(number * parents.length + k, matrix);
          drawn.setColorAt(number * parents.length + k, colour);
        });
      });
      drawn.instanceMatrix.needsUpdate = true;
      drawn.instanceColor.needsUpdate = true;
      page.viewer.set_dirty();
    }
    return { show, visible: (on) => { group.visible = on; page.viewer.set_dirty(); } };
  }

  return { make };
})();
