"use strict";
(function () {
  const THREE = MeshCat.THREE;
  const scene = JSON.parse(document.getElementById("scene").textContent);
  const stage = document.getElementById("stage");
  const pane = document.getElementById("pane");
  const smallest = matchMedia("(prefers-reduced-motion: reduce)").matches;
  const wish = new URLSearchParams(location.hash.slice(1)); // such as #motion=2&phase=0.25

  // Numbers of meshes stand in the page once each and are called by name.
  const kinds = { Float32Array, Uint16Array, Uint32Array };
  const arrays = {};
  for (const [name, text] of Object.entries(scene.arrays)) {
    arrays[name] = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0)).buffer;
  }
  function unpacked({ low, step }, buffer) { // places as whole numbers between the least and the largest
    return Float32Array.from(new Uint16Array(buffer), (count, i) => low[i % 3] + step[i % 3] * count);
  }
  function fill(value) {
    if (Array.isArray(value) || value === null || typeof value !== "object") return value;
    for (const key of Object.keys(value)) {
      const inner = value[key];
      if (key === "array" && inner && inner.buffer !== undefined) value.array = value.low ? unpacked(value, arrays[inner.buffer]) : new kinds[value.type](arrays[inner.buffer]);
      else if (key === "geometries") inner.forEach(fill);
      else fill(inner);
    }
    return value;
  }

  document.body.classList.toggle("picture", wish.has("picture")); // without the words beside it

  // Without a graphics card the processor draws: smooth edges and many triangles then only in a picture that stands.
  function drawnBySoftware() {
    const probe = document.createElement("canvas").getContext("webgl");
    if (!probe) return false;
    const told = probe.getExtension("WEBGL_debug_renderer_info");
    const name = told ? probe.getParameter(told.UNMASKED_RENDERER_WEBGL) : "";
    const leave = probe.getExtension("WEBGL_lose_context");
    if (leave) leave.loseContext();
    return /swiftshader|llvmpipe|softpipe|software|basic render/i.test(name);
  }
  const software = !wish.has("picture") && drawnBySoftware();

  let viewer;
  try {
    // The drawing is kept so that a printer finds it.
    const renderer = new THREE.WebGLRenderer({ antialias: !software, alpha: !software, preserveDrawingBuffer: true });
    pane.appendChild(renderer.domElement);
    viewer = new MeshCat.Viewer(pane, false, renderer);
  } catch (error) {
    const trouble = document.getElementById("trouble");
    trouble.textContent = "The picture needs WebGL, which this browser does not offer.";
    trouble.hidden = false;
    return;
  }
  window.viewer = viewer;
  const node = (path) => viewer.scene_tree.find(path.split("/").filter((part) => part)).object;
  // Pixels of the drawing for each of the page, standing and moving in software.
  const SHARP = 2, ROUGH = 0.6, CALM = 250; // [ms] until what has moved stands
  let rough = false, hurried = -Infinity, calm = 0;
  function detail(fewer) {
    rough = fewer;
    viewer.renderer.setPixelRatio(rough ? ROUGH : SHARP);
    scene.rough.forEach(([fine, coarse]) => { node(fine).visible = !rough; node(coarse).visible = rough; });
    viewer.set_dirty();
  }
  function hurry() { // told of everything that moves; what moves once need not be quick
    if (!software) return;
    const now = performance.now();
    if (!rough && now - hurried < CALM) detail(true);
    hurried = now;
    clearTimeout(calm);
    calm = setTimeout(() => { if (rough) detail(false); }, CALM);
  }
  let busy = 0;
  // What scripts after this one may use.
  window.flexmodalPage = {
    viewer, node, stage, hurry, software,
    busy: (more) => { busy += more; document.body.classList.toggle("busy", busy > 0); }, // something is still being worked out
    frame: (points) => { scene.view.points = points; touched = false; frame(); },
  };

  // A planar arm is seen without perspective, so that it can be measured against its grid.
  if (scene.view.flat) {
    const camera = new THREE.OrthographicCamera(-1, 1, 1, -1, 0.01, 100);
    viewer.controls.dispose();
    viewer.set_camera(camera);
    viewer.set_object(["Cameras", "default", "rotated"], camera);
  }

  viewer.set_3d_pane_size = function () {
    const camera = viewer.camera;
    camera.aspect = stage.clientWidth / stage.clientHeight;
    if (camera.isOrthographicCamera) {
      camera.left = camera.bottom * camera.aspect;
      camera.right = camera.top * camera.aspect;
    }
    viewer.renderer.setSize(stage.clientWidth, stage.clientHeight);
    camera.updateProjectionMatrix();
    viewer.set_dirty();
    if (!touched) frame();
  };

  // The camera: near enough that everything is just inside, whatever the shape of the window.
  let touched = false;
  const up_of_three = (p) => new THREE.Vector3(p[0], p[2], -p[1]);
  function frame() {
    const look = up_of_three(scene.view.look).normalize();
    const camera = viewer.camera;
    const flat = camera.isOrthographicCamera;
    camera.fov = scene.view.fov;
    const vertical = Math.abs(look.y) > 0.999;
    const right = vertical ? new THREE.Vector3(1, 0, 0) : new THREE.Vector3().crossVectors(look, new THREE.Vector3(0, 1, 0)).normalize();
    const up = new THREE.Vector3().crossVectors(right, look);
    const seen = scene.view.points.map(up_of_three).map((p) => [p.dot(right), p.dot(up), p.dot(look)]);
    const pads = [Math.min(0.14, 54 / stage.clientWidth), Math.min(0.14, 36 / stage.clientHeight)];
    const tall = Math.tan((camera.fov * Math.PI) / 360);
    const wide = tall * (stage.clientWidth / stage.clientHeight);
    const slope = [wide * (1 - 2 * pads[0]), tall * (1 - 2 * pads[1])];
    // A point at (x, y, depth) is inside when |x − cx| ≤ slope (distance + depth): four planes, each as near as it may be.
    // Without perspective the depth does not count, and "distance" is half the height of the picture over the slope.
    const centre = [0, 0];
    let distance = 0;
    for (const axis of [0, 1]) {
      const lean = flat ? 0 : slope[axis];
      const high = Math.max(...seen.map((p) => p[axis] - lean * p[2]));
      const low = Math.min(...seen.map((p) => p[axis] + lean * p[2]));
      centre[axis] = (high + low) / 2;
      distance = Math.max(distance, (high - low) / 2 / slope[axis]);
    }
    const middle = (Math.min(...seen.map((p) => p[2])) + Math.max(...seen.map((p) => p[2]))) / 2;
    const away = flat ? 4 * distance : distance + middle;
    if (flat) {
      camera.top = distance * tall;
      camera.bottom = -camera.top;
      camera.right = distance * wide;
      camera.left = -camera.right;
      camera.zoom = 1;
    }
    const target = new THREE.Vector3().addScaledVector(right, centre[0]).addScaledVector(up, centre[1]).addScaledVector(look, middle);
    const eye = target.clone().addScaledVector(look, -away);
    if (vertical) eye.z += away * 1e-5;
    camera.near = away / 200;
    camera.far = away * 20;
    camera.position.copy(eye);
    viewer.controls.target.copy(target);
    viewer.controls.update();
    viewer.set_dirty();
  }

  // Labels are text on the page that follows the drawing.
  const tags = scene.labels.map((label) => {
    const tag = document.createElement("span");
    tag.textContent = label.text;
    tag.className = label.kind;
    document.getElementById("labels").appendChild(tag);
    return { tag, path: label.path, kind: label.kind, width: 0 };
  });
  tags.sort((a, b) => b.tag.textContent.endsWith(" m") - a.tag.textContent.endsWith(" m"));
  const place = new THREE.Vector3();
  const sides = (w) => [[9, -8], [-w / 2, -25], [-w / 2, 10], [-9 - w, -8], [-w / 2, -42], [-w / 2, 27], [9, -25], [9, 10], [-9 - w, -25], [-9 - w, 10], [-w / 2, -59], [-w / 2, 44], [-w / 2, -76]];
  const apart = (a, b) => a[0] > b[0] + b[2] || b[0] > a[0] + a[2] || a[1] > b[1] + b[3] || b[1] > a[1] + a[3];
  const seen_with = (object) => object === null || (object.visible && seen_with(object.parent));
  function put_labels() {
    const taken = [];
    const ticks = [];
    for (const item of tags) {
      item.gone = !seen_with(node(item.path)); // its node belongs to another motion
      if (item.gone) continue;
      if (!item.width) item.width = item.tag.offsetWidth;
      node(item.path).getWorldPosition(place).project(viewer.camera);
      item.at = [((place.x + 1) / 2) * stage.clientWidth, ((1 - place.y) / 2) * stage.clientHeight, place.z];
      if (item.kind === "point" || item.kind === "mark") taken.push([item.at[0] - 6, item.at[1] - 6, 12, 12]);
    }
    for (const item of tags) {
      if (item.gone) {
        item.tag.style.visibility = "hidden";
        continue;
      }
      const [x, y, depth] = item.at;
      let left = x + 9, top = y - 8;
      if (item.kind.includes("below")) { left = x - item.width / 2; top = y + 4; }
      else if (item.kind.includes("beside")) { left = x - item.width - 4; }
      else if (item.kind.includes("axis")) { left = x - item.width / 2; }
      else {
        // Where it stood before, or the first side on which it covers no other label and no point.
        const boxes = sides(item.width).map(([dx, dy]) => [x + dx, y + dy, item.width, 16]);
        const fits = (box) => box[0] > 2 && box[0] + box[2] < stage.clientWidth - 2 && taken.every((other) => apart(box, other));
        if (item.side === undefined || !fits(boxes[item.side])) item.side = Math.max(0, boxes.findIndex(fits));
        [left, top] = boxes[item.side];
        taken.push(boxes[item.side]);
      }
      // Numbers along a grid that would run into one another are left out; the one with the unit stays.
      let crowded = false;
      if (item.kind.includes("tick")) {
        const box = [left - 3, top, item.width + 6, 14];
        crowded = !ticks.every((other) => apart(box, other));
        if (!crowded) ticks.push(box);
      }
      const outside = depth > 1 || x < 0 || y < 0 || x > stage.clientWidth || y > stage.clientHeight;
      item.tag.style.visibility = outside || crowded ? "hidden" : "visible";
      item.tag.style.transform = `translate(${left.toFixed(1)}px, ${top.toFixed(1)}px)`;
    }
  }
  viewer.render = function () {
    if (viewer.animator.playing) hurry();
    viewer.scene.updateMatrixWorld();
    MeshCat.Viewer.prototype.render.call(viewer);
    put_labels();
  };

  scene.commands.forEach((command) => viewer.handle_command(fill(command)));
  scene.rough.forEach(([, coarse]) => { node(coarse).visible = false; });
  if (software) viewer.renderer.setPixelRatio(SHARP);

  // Lines that lie on the ground of the page follow its colours.
  const dark = matchMedia("(prefers-color-scheme: dark)");
  function recolour() {
    const colours = { grid: dark.matches ? 0x3a424b : 0xd9dce0, axes: dark.matches ? 0xa3abb5 : 0x4b5058 };
    for (const [path, colour] of Object.entries(colours)) {
      node(`/flexmodal/${path}`).traverse((object) => { if (object.material) object.material.color.setHex(colour); });
    }
    if (software) viewer.renderer.setClearColor(dark.matches ? 0x14171a : 0xffffff); // nothing to be seen through it
    viewer.set_dirty();
  }
  recolour();
  dark.addEventListener("change", recolour);

  // Motions: a button each; the one chosen is loaded as a meshcat animation.
  const buttons = [...document.querySelectorAll("button[data-motion]")];
  const pause = document.getElementById("pause");
  const shown = new Set(scene.motions.flatMap((motion) => motion.shows));
  function choose(number) {
    const motion = scene.motions[number];
    shown.forEach((path) => { node(path).visible = motion !== undefined && motion.shows.includes(path); });
    viewer.animator.pause();
    const moves = motion !== undefined && motion.animations.length > 0;
    if (!moves) viewer.animator.clear();
    if (motion !== undefined) motion.poses.forEach(([path, matrix]) => viewer.set_transform(path.split("/").filter((part) => part), matrix));
    if (moves) {
      viewer.handle_command({
        type: "set_animation",
        animations: JSON.parse(JSON.stringify(motion.animations)),
        options: { play: true, repetitions: 1e9 },
      });
    }
    buttons.forEach((button) => button.setAttribute("aria-pressed", String(Number(button.dataset.motion) === number)));
    document.querySelectorAll("[data-of]").forEach((part) => { part.hidden = Number(part.dataset.of) !== number; });
    if (pause) pause.hidden = !moves;
    run(moves);
    viewer.set_dirty();
  }
  function run(play) {
    if (play) viewer.animator.play();
    else viewer.animator.pause();
    if (pause) pause.textContent = play ? "Pause" : "Play";
  }
  function hold(phase) {
    const motion = scene.motions.find((_, number) => buttons.some((b) => Number(b.dataset.motion) === number && b.getAttribute("aria-pressed") === "true"));
    run(false);
    if (motion && motion.animations.length) viewer.animator.seek(phase * motion.duration);
  }
  window.flexmodalPage.hold = hold; // at a part of the cycle
  buttons.forEach((button) => button.addEventListener("click", () => choose(Number(button.dataset.motion))));
  if (pause) pause.addEventListener("click", () => run(!viewer.animator.playing));

  viewer.controls.addEventListener("start", () => { touched = true; });
  viewer.controls.addEventListener("change", hurry);
  const again = document.getElementById("reset-view");
  again.addEventListener("click", () => { touched = false; frame(); });

  const first = scene.rest ? -1 : 0;
  choose(wish.has("motion") ? Number(wish.get("motion")) : first);
  if (wish.has("phase")) hold(Number(wish.get("phase")));
  else if (smallest) hold(scene.motions.length && !scene.rest ? scene.motions[0].extreme : 0);
  new ResizeObserver(() => viewer.set_3d_pane_size()).observe(stage);
  viewer.set_3d_pane_size();
  addEventListener("beforeprint", () => { viewer.set_3d_pane_size(); viewer.render(); });
  viewer.animate();
})();
