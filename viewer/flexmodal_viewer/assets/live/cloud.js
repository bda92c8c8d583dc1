"use strict";
// The places of a workspace map in meshcat's scene: squares behind a planar arm, balls around any other.
const Cloud = (() => {
  const BALL = 0.36; // across, as a part of a cell
  const REACH = 16; // of a click [pixels]

  function disc(THREE) { // a round picture for a point, darker at its rim so that it stands out on any ground
    const canvas = document.createElement("canvas");
    canvas.width = canvas.height = 64;
    const pen = canvas.getContext("2d");
    for (const [radius, grey] of [[31, "#8c8c8c"], [24, "#ffffff"]]) {
      pen.fillStyle = grey;
      pen.beginPath();
      pen.arc(32, 32, radius, 0, 2 * Math.PI);
      pen.fill();
    }
    return new THREE.CanvasTexture(canvas);
  }

  function make(page, map) {
    const THREE = MeshCat.THREE;
    const { viewer, node, stage } = page;
    const flat = map.spread.length < 3;
    const square = flat && viewer.camera.isOrthographicCamera; // seen so that a click falls into one of the squares
    const group = node("/flexmodal/map");
    const across = flat ? [0, 1, 2].find((axis) => !map.spread.includes(axis)) : null;
    const corners = flat ? 4 : 1;
    const half = 0.47 * map.cell;
    const positions = map.places.flatMap(({ at }) => {
      if (!flat) return at;
      const [a, b] = map.spread;
      return [[-1, -1], [1, -1], [1, 1], [-1, 1]].flatMap(([u, v]) => { const p = [...at]; p[a] += u * half; p[b] += v * half; return p; });
    });
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.Float32BufferAttribute(positions, 3));
    geometry.setAttribute("color", new THREE.Float32BufferAttribute(new Float32Array(positions.length), 3));
    const lens = Math.tan((viewer.camera.fov * Math.PI) / 360); // three.js takes the size of a point at half a window's width
    const drawn = flat
      ? new THREE.Mesh(geometry, new THREE.MeshBasicMaterial({ vertexColors: true, side: THREE.DoubleSide, depthWrite: false, depthTest: false }))
      : new THREE.Points(geometry, new THREE.PointsMaterial({ size: (BALL * map.cell) / lens, vertexColors: true, map: disc(THREE), alphaTest: 0.5 }));
    drawn.renderOrder = flat ? -5 : 0; // behind the arm
    drawn.frustumCulled = false;
    const mark = new THREE.Mesh(new THREE.TorusGeometry(0.4 * map.cell, 0.06 * map.cell, 8, 40), new THREE.MeshBasicMaterial({ color: 0xd55e00, depthTest: false, transparent: true }));
    mark.renderOrder = 9;
    mark.visible = false;
    if (flat) mark.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), new THREE.Vector3(...[0, 1, 2].map((axis) => Number(axis === across))));
    group.clear();
    group.add(drawn, mark);

    // Those to be seen, by number, each in the colour of its part from 0 to 1.
    let seen = [];
    function paint(numbers, parts) {
      seen = numbers;
      const colours = geometry.attributes.color;
      parts.forEach((part, number) => {
        const rgb = Colours.at(part).map((value) => value / 255);
        for (let k = 0; k < corners; k++) colours.setXYZ(corners * number + k, ...rgb);
      });
      colours.needsUpdate = true;
      const order = flat ? (n) => [0, 1, 2, 0, 2, 3].map((k) => 4 * n + k) : (n) => [n];
      geometry.setIndex(numbers.flatMap(order));
      viewer.set_dirty();
    }

    function choose(number) {
      mark.visible = number !== null;
      if (number !== null) mark.position.set(...map.places[number].at);
      if (!flat) mark.quaternion.copy(viewer.camera.getWorldQuaternion(new THREE.Quaternion())).premultiply(group.getWorldQuaternion(new THREE.Quaternion()).invert());
      viewer.set_dirty();
    }

    // The place under the pointer: of those within reach the one in front.
    const world = (p) => new THREE.Vector3(p[0], p[2], -p[1]);
    function near(event) {
      const box = stage.getBoundingClientRect();
      const reach = square ? 400 : REACH;
      const found = seen.map((number) => {
        const p = world(map.places[number].at).project(viewer.camera);
        const [x, y] = [box.left + ((p.x + 1) / 2) * box.width, box.top + ((1 - p.y) / 2) * box.height];
        return { number, away: Math.hypot(event.clientX - x, event.clientY - y), depth: p.z };
      }).filter(({ away }) => away < reach);
      found.sort(flat ? (a, b) => a.away - b.away : (a, b) => a.depth - b.depth);
      if (!found.length) return null;
      if (!square) return found[0].number;
      const [p, q] = [map.places[found[0].number].at, unprojected(event)]; // inside its square
      return map.spread.every((axis) => Math.abs(p[axis] - q[axis]) <= map.cell / 2) ? found[0].number : null;
    }
    function unprojected(event) { // without perspective the depth does not count
      const box = stage.getBoundingClientRect();
      const p = new THREE.Vector3((2 * (event.clientX - box.left)) / box.width - 1, 1 - (2 * (event.clientY - box.top)) / box.height, 0).unproject(viewer.camera);
      return [p.x, -p.z, p.y];
    }

    return { paint, choose, near, show: (visible) => { group.visible = visible; viewer.set_dirty(); } };
  }

  return { make };
})();
