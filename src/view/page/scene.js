'use strict';

// The clouds in 3-D.

const COLOURS = { source: 0xe69f00, target: 0x0072b2, second: 0xcc79a7, faint: 0xaab2bb, undetermined: 0xb3261e,
  arrow: 0x1b1f24 };

const POINT_VERTEX = `
  attribute float before;
  attribute float after;
  uniform float time;
  uniform float size;
  uniform float nearer;
  varying float distance_;
  void main() {
    distance_ = mix(before, after, time);
    gl_PointSize = size;
    gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
    gl_Position.z -= nearer * gl_Position.w;
  }`;
const POINT_FRAGMENT = `
  uniform vec3 colour;
  uniform bool by_distance;
  uniform vec2 range;
  varying float distance_;
  vec3 ramp(float t) {
    const vec3 a = vec3(0.051, 0.031, 0.529), b = vec3(0.494, 0.012, 0.659), c = vec3(0.8, 0.278, 0.471),
               d = vec3(0.973, 0.584, 0.251), e = vec3(0.941, 0.847, 0.0);
    t *= 4.0;
    return t < 1.0 ? mix(a, b, t) : t < 2.0 ? mix(b, c, t - 1.0) : t < 3.0 ? mix(c, d, t - 2.0) : mix(d, e, t - 3.0);
  }
  void main() {
    if (length(gl_PointCoord - 0.5) > 0.5) discard;
    float place = clamp(log(max(distance_, range.x) / range.x) / log(range.y / range.x), 0.0, 1.0);
    gl_FragColor = vec4(by_distance ? ramp(place) : colour, 1.0);
  }`;

// Of the depth from -1 to 1: about a thousandth of the way to the middle, less than a mark's size. So far behind the
// target a source's point is still drawn over it, as rounding would hide what lies on the target; a target's mark is
// wider, so that it is seen around it.
const NEARER = 1e-5;
const TARGET_WIDER = 1.4;

function cloudMaterial(colour, size, nearer) {
  return new THREE.ShaderMaterial({
    vertexShader: POINT_VERTEX,
    fragmentShader: POINT_FRAGMENT,
    uniforms: {
      colour: { value: new THREE.Color(colour) }, size: { value: size }, nearer: { value: nearer },
      time: { value: 1 },
      by_distance: { value: false }, range: { value: new THREE.Vector2(1, 2) } } });
}

function pointsOf(xyz, before, after, material) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(xyz, 3));
  geometry.setAttribute('before', new THREE.BufferAttribute(before, 1));
  geometry.setAttribute('after', new THREE.BufferAttribute(after, 1));
  const points = new THREE.Points(geometry, material);
  points.frustumCulled = false;
  return points;
}

function poseOf(rows) {
  const matrix = new THREE.Matrix4().set(...rows.flat());
  const pose = { position: new THREE.Vector3(), turn: new THREE.Quaternion() };
  matrix.decompose(pose.position, pose.turn, new THREE.Vector3());
  return pose;
}

/** The largest of 1, 2, 5, 10, ... that is no more. */
function roundLength(most) {
  const decade = 10 ** Math.floor(Math.log10(most));
  return decade * (most >= 5 * decade ? 5 : most >= 2 * decade ? 2 : 1);
}

class Scene {
  /**
   * @param {HTMLElement} view to draw in
   * @param {SVGElement} axes to show which way x, y and z go
   * @throws where there is no WebGL
   */
  constructor(view, axes) {
    this.view = view;
    this.axes = axes;
    this.renderer = new THREE.WebGLRenderer({ antialias: true });
    this.renderer.setPixelRatio(window.devicePixelRatio);
    this.renderer.setClearColor(0xf6f8fa);
    view.prepend(this.renderer.domElement);
    this.renderer.domElement.tabIndex = 0;
    this.camera = new THREE.PerspectiveCamera(28, 1, 0.1, 1000);
    this.camera.up.set(0, 0, 1);
    this.controls = new THREE.OrbitControls(this.camera, this.renderer.domElement);
    this.controls.enableKeys = false;
    this.controls.addEventListener('change', () => this.draw());
    this.resizes = new ResizeObserver(() => this.resize());
    this.resizes.observe(view);
  }

  /** @param pair as in the data of the page */
  show(pair) {
    this.pair = pair;
    this.scene = new THREE.Scene();
    this.world = new THREE.Group();
    this.scene.add(this.world);
    this.poses = pair.poses.map((pose) => poseOf(pose.matrix));
    this.time = 1;

    const target = floats(pair.target.block);
    const source = floats(pair.source.block);
    const sizeFor = (points) =>
      window.devicePixelRatio * Math.min(5, Math.max(1.6, 5 - Math.log10(points / 300) * 1.3));
    const none = new Float32Array(target.length / 3);
    const size = TARGET_WIDER * sizeFor(target.length / 3);
    this.target = pointsOf(target, none, none, cloudMaterial(COLOURS.target, size, 0));
    this.world.add(this.target);
    const before = floats(pair.poses[0].block);
    this.sources = pair.poses.slice(1).map((pose, i) => {
      const material = cloudMaterial(i ? COLOURS.second : COLOURS.source, sizeFor(source.length / 3), NEARER);
      material.uniforms.range.value.set(pair.histogram.edges[0], pair.histogram.edges[pair.histogram.edges.length - 1]);
      const points = pointsOf(source, before, floats(pose.block), material);
      this.world.add(points);
      return points;
    });
    this.select([0]);

    this.box = new THREE.Box3(new THREE.Vector3(...pair.box.low), new THREE.Vector3(...pair.box.high));
    this.centre = this.box.getCenter(new THREE.Vector3());
    this.radius = Math.max(this.box.getSize(new THREE.Vector3()).length() / 2, 1e-9);
    this.outline = this.outlineOf(target, source);
    this.addGrid();
    this.addArrows();
    this.resize();
    this.look('reset');
  }

  /** Gives back what the graphics card holds: a browser has but a few such views. */
  close() {
    this.resizes.disconnect();
    cancelAnimationFrame(this.awaited);
    this.renderer.dispose();
    this.renderer.getContext().getExtension('WEBGL_lose_context').loseContext();
  }

  addGrid() {
    this.square = roundLength(this.radius / 4);
    const squares = 2 * Math.ceil(this.radius / this.square);
    this.grid = new THREE.GridHelper(squares * this.square, squares, 0xd1d5da, 0xe4e7ea);
    this.grid.rotation.x = Math.PI / 2;
    this.grid.position.set(this.centre.x, this.centre.y, this.box.min.z);
    this.scene.add(this.grid);
  }

  /** Of each direction in which the answer is more or less sure; two ways where nothing determines it. */
  addArrows() {
    this.uncertainty = new THREE.Group();
    this.uncertainty.visible = false;
    this.scene.add(this.uncertainty);
    const found = this.pair.result && this.pair.result.uncertainty;
    if (!found) return;
    const at = new THREE.Vector3(...found.centre.map((value, i) => value - this.pair.centre[i]));
    const arrow = (direction, length, colour) =>
      this.uncertainty.add(new THREE.ArrowHelper(direction, at, length, colour, this.radius / 14, this.radius / 30));
    const both = (direction, length, colour) => {
      arrow(direction, length, colour);
      arrow(direction.clone().negate(), length, colour);
    };
    const none = 1e-9 * this.radius;
    const largest = Math.max(...found.shifts.map((axis) => axis.deviation || 0));
    this.enlarged = largest > none ? roundLength(0.35 * this.radius / largest) : 1;
    for (const axis of found.shifts) {
      const direction = new THREE.Vector3(...axis.direction);
      if (axis.deviation === null) both(direction, 0.8 * this.radius, COLOURS.undetermined);
      else if (axis.deviation > none) both(direction, this.enlarged * axis.deviation, COLOURS.arrow);
    }
    for (const axis of found.turns_degrees) {
      if (axis.deviation !== null) continue;
      const ring = new THREE.Mesh(new THREE.TorusGeometry(this.radius / 3, this.radius / 160, 8, 64),
        new THREE.MeshBasicMaterial({ color: COLOURS.undetermined }));
      const direction = new THREE.Vector3(...axis.direction);
      ring.position.copy(at);
      ring.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), direction);
      this.uncertainty.add(ring);
      both(direction, this.radius / 2, COLOURS.undetermined);
    }
  }

  /** Which of the results are shown. */
  select(shown) {
    this.sources.forEach((points, i) => { points.visible = shown.includes(i); });
    this.setTime(this.time);
  }

  /** @param {number} time from 0, before, to 1, after */
  setTime(time) {
    this.time = time;
    this.sources.forEach((points, i) => {
      points.position.lerpVectors(this.poses[0].position, this.poses[i + 1].position, time);
      THREE.Quaternion.slerp(this.poses[0].turn, this.poses[i + 1].turn, points.quaternion, time);
      points.material.uniforms.time.value = time;
    });
    this.draw();
  }

  colourByDistance(on) {
    for (const points of this.sources) points.material.uniforms.by_distance.value = on;
    this.target.material.uniforms.colour.value.set(on ? COLOURS.faint : COLOURS.target);
    this.draw();
  }

  showArrows(on) {
    this.uncertainty.visible = on;
    this.draw();
  }

  /** @param {string} from above, front, side or reset */
  look(from) {
    const towards = { above: [0, 0, 1], front: [0, -1, 0], side: [1, 0, 0], reset: [0.55, -0.75, 0.5] }[from];
    const away = this.distanceTo(new THREE.Vector3(...towards).normalize());
    this.camera.near = away / 200;
    this.camera.far = away * 200;
    this.camera.updateProjectionMatrix();
    this.controls.target.copy(this.centre);
    // Straight from above the way up would not be known.
    this.camera.position.set(...towards).normalize().multiplyScalar(away).add(this.centre);
    if (from === 'above') this.camera.position.y -= away * 1e-4;
    this.controls.update();
    this.draw();
  }

  /** From how far a camera in that direction has all in its picture. */
  distanceTo(direction) {
    const right = new THREE.Vector3().crossVectors(this.camera.up, direction);
    if (right.lengthSq() < 1e-6) right.set(1, 0, 0);
    right.normalize();
    const up = new THREE.Vector3().crossVectors(direction, right);
    const slope = 0.93 * Math.tan(this.camera.fov * Math.PI / 360);
    let away = 0;
    for (const point of this.outline) {
      const widest = Math.max(Math.abs(point.dot(right)) / this.camera.aspect, Math.abs(point.dot(up)));
      away = Math.max(away, point.dot(direction) + widest / slope);
    }
    return away || this.radius;
  }

  /** Some points of what there is to see, about the centre. */
  outlineOf(target, source) {
    const outline = [];
    const add = (xyz, place) => {
      const step = 3 * Math.ceil(xyz.length / 3 / 4000);
      for (let i = 0; i < xyz.length; i += step) {
        const point = place(new THREE.Vector3(xyz[i], xyz[i + 1], xyz[i + 2]));
        if (this.box.containsPoint(point)) outline.push(point.sub(this.centre));
      }
    };
    add(target, (point) => point);
    for (const pose of this.poses) add(source, (point) => point.applyQuaternion(pose.turn).add(pose.position));
    return outline;
  }

  zoom(factor) {
    this.camera.position.sub(this.controls.target).multiplyScalar(factor).add(this.controls.target);
    this.controls.update();
  }

  resize() {
    const { clientWidth, clientHeight } = this.view;
    if (!this.scene || !clientWidth || !clientHeight) return;
    this.renderer.setSize(clientWidth, clientHeight);
    this.camera.aspect = clientWidth / clientHeight;
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  /** With the next picture of the screen, once however often it is asked for. */
  draw() {
    if (this.awaited) return;
    this.awaited = requestAnimationFrame(() => {
      this.awaited = 0;
      this.renderer.render(this.scene, this.camera);
      this.drawAxes();
    });
  }

  drawAxes() {
    const svg = (name, attributes) => {
      const made = document.createElementNS('http://www.w3.org/2000/svg', name);
      for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
      return made;
    };
    this.axes.textContent = '';
    ['x', 'y', 'z'].forEach((name, i) => {
      const way = new THREE.Vector3().setComponent(i, 1).transformDirection(this.camera.matrixWorldInverse);
      this.axes.append(svg('line', { x1: 0, y1: 0, x2: 28 * way.x, y2: -28 * way.y }));
      const label = svg('text', { x: 39 * way.x, y: -39 * way.y });
      label.textContent = Math.hypot(way.x, way.y) > 0.15 ? name : '';
      this.axes.append(label);
    });
  }
}
