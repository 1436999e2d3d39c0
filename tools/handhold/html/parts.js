// What was found, as bodies in the scene: handles, affordances, approaches, hands, samples.

const kHand = "#d3dae2", kShell = "#22dcf2";
const kLift = 0.005;  // m; more than the noise of a depth camera at arm's length
const kY = new THREE.Vector3(0, 1, 0);

/** Turns and moves an object that lies along its y. */
function lieAlong(object, center, axis) {
  object.position.copy(center);
  object.quaternion.setFromUnitVectors(kY, axis);
}

/** An arrow that ends at `tip`. */
function arrow(from, tip, color, thickness = 0.0016) {
  const direction = tip.clone().sub(from);
  const length = direction.length(), head = Math.min(0.018, 0.4 * length);
  direction.normalize();
  const material = glass(0.95, 1, { color, depthWrite: true });
  const shaft = new THREE.Mesh(
    new THREE.CylinderBufferGeometry(thickness, thickness, Math.max(length - head, 1e-6), 12), material);
  lieAlong(shaft, from.clone().addScaledVector(direction, (length - head) / 2), direction);
  const cone = new THREE.Mesh(new THREE.ConeBufferGeometry(3.4 * thickness, head, 20), material);
  lieAlong(cone, tip.clone().addScaledVector(direction, -head / 2), direction);
  const group = new THREE.Group();
  group.add(shaft, cone);
  return group;
}

/** A handle: its tube, solid rings at its ends, and a hint of it where the cloud hides it. */
class HandlePart {
  constructor(handle, index, color) {
    this.radius = handle.radius;
    this.handle = handle;
    this.index = index;
    this.color = color;
    this.center = vector(handle.center);
    this.group = new THREE.Group();
    // A little outside of the points that it was fitted to.
    const radius = 1.02 * handle.radius + 0.0006;
    const path = (handle.path || []).map(vector);
    const axis = vector(handle.axis).normalize();
    const ends = [-0.5, 0.5].map((share) => this.center.clone().addScaledVector(axis, share * handle.length));
    const curved = path.length > 1;
    let tube;
    if (curved) {
      const curve = new THREE.CatmullRomCurve3(path, false, "centripetal");
      const geometry = new THREE.TubeBufferGeometry(curve, 8 * path.length, radius, 32);
      tube = () => new THREE.Mesh(geometry);
      this.rings = [[path[0], curve.getTangent(0)], [path[path.length - 1], curve.getTangent(1)]];
    } else {
      const geometry = new THREE.CylinderBufferGeometry(radius, radius, handle.length, 48, 1, true);
      tube = () => {
        const mesh = new THREE.Mesh(geometry);
        lieAlong(mesh, this.center, axis);
        return mesh;
      };
      this.rings = ends.map((end) => [end, axis]);
    }
    const seen = tube(), hidden = tube();
    this.material = glass(0.3, 1, { color, side: THREE.DoubleSide, lift: kLift });
    seen.material = this.material;
    hidden.material = glass(0.05, 0.35, { color, lift: kLift, side: THREE.DoubleSide, depthFunc: THREE.GreaterDepth });
    this.body = seen;
    this.group.add(seen, hidden);
    /** Along its middle, for what keeps clear of it. */
    this.line = curved ? path : [ends[0], this.center, ends[1]];
    this.ringMaterial = glass(0.95, 1, { color, depthWrite: true, lift: kLift });
    for (const [place, direction] of this.rings) {
      const ring = new THREE.Mesh(new THREE.TorusBufferGeometry(radius, 0.0012, 10, 48), this.ringMaterial);
      ring.position.copy(place);
      ring.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), direction);
      this.group.add(ring);
    }
    const approach = vector(handle.approach);
    const tip = this.center.clone().addScaledVector(approach, -handle.radius - 0.004);
    this.approach = arrow(tip.clone().addScaledVector(approach, -0.07), tip, color);
  }

  setChosen(chosen, other) {
    this.material.uniforms.body.value = chosen ? 0.62 : other ? 0.16 : 0.3;
    this.material.uniforms.rim.value = other ? 0.6 : 1;
    this.ringMaterial.uniforms.tint.value.set(chosen ? "#ffffff" : this.color);
  }
}

/** The affordances' shells: cylinders as wide as a finger. */
function makeShells(page) {
  const { affordances, handles } = page.result;
  const geometry = new THREE.CylinderBufferGeometry(1, 1, 1, 24, 1, true);
  const colors = affordances.map(() => new THREE.Color(kShell));
  handles.forEach((handle, i) => handle.affordances.forEach((k) => colors[k].set(page.handleColor(i))));
  const tints = new Float32Array(3 * affordances.length);
  colors.forEach((color, i) => color.toArray(tints, 3 * i));
  geometry.setAttribute("tint", new THREE.InstancedBufferAttribute(tints, 3));
  const material = glass(0.004, 0.16, { side: THREE.DoubleSide, lift: kLift });
  const shells = new THREE.InstancedMesh(geometry, material, affordances.length);
  const one = new THREE.Object3D();
  affordances.forEach(({ center, axis, radius }, i) => {
    lieAlong(one, vector(center), vector(axis));
    one.scale.set(radius, page.view.finger_width, radius);
    one.updateMatrix();
    shells.setMatrixAt(i, one.matrix);
  });
  shells.frustumCulled = false;
  return shells;
}

/** Samples in the colour of the step at which they ended, a little in front of the points that they are. */
function makeSamples(page) {
  const { view, samples, steps } = page;
  const palette = view.step_colors.map(({ color }) => new THREE.Color(color));
  const colors = new Float32Array(3 * view.samples);
  for (let i = 0; i < view.samples; ++i) palette[steps[i]].toArray(colors, 3 * i);
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(samples, 4, true));
  geometry.setAttribute("color", new THREE.BufferAttribute(colors, 3));
  const points = new THREE.Points(geometry, new THREE.ShaderMaterial({
    vertexShader: `
uniform vec3 lower, size;
uniform float pixels;
attribute vec3 color;
varying vec3 vColor;
void main() {
  vec4 p = modelViewMatrix * vec4(lower + position * size, 1.0);
  p.xyz *= 1.0 - min(0.004 / length(p.xyz), 0.5);
  gl_Position = projectionMatrix * p;
  gl_PointSize = pixels;
  vColor = color;
}`,
    fragmentShader: kPointFragment,
    uniforms: {
      lower: { value: vector(view.cloud.lower) },
      size: { value: vector(view.cloud.size) },
      pixels: { value: 4 * Math.min(window.devicePixelRatio || 1, 2) },
    },
  }));
  points.frustumCulled = false;
  return points;
}

function bodyGeometry({ kind, size: [x, y, z] }) {
  if (kind === "box") return new THREE.BoxBufferGeometry(x, y, z);
  if (kind === "sphere") return new THREE.SphereBufferGeometry(x / 2, 24, 16);
  const cylinder = new THREE.CylinderBufferGeometry(x / 2, x / 2, z, 32);
  cylinder.rotateX(Math.PI / 2);
  return cylinder;
}

/** The hand at a planned grasp, and the way that it comes. */
function makeGrasp(grasp, color) {
  const group = new THREE.Group();
  for (const body of grasp.hand) {
    const { R, t } = body;
    const geometry = bodyGeometry(body);
    // What is large is no finger; one looks through it at what the fingers do.
    const large = Math.max(...body.size) > 0.08 || body.size[0] * body.size[1] > 0.002;
    const material = large ? glass(0.2, 0.7, { color: kHand }) : glass(0.85, 1, { color: kHand, depthWrite: true });
    const mesh = new THREE.Mesh(geometry, material);
    const edges = new THREE.LineSegments(
      new THREE.EdgesGeometry(geometry, 30), new THREE.LineBasicMaterial({ color }));
    for (const object of [mesh, edges]) {
      object.matrixAutoUpdate = false;
      object.matrix.set(R[0], R[1], R[2], t[0], R[3], R[4], R[5], t[1], R[6], R[7], R[8], t[2], 0, 0, 0, 1);
      group.add(object);
    }
  }
  const from = vector(grasp.from), to = vector(grasp.to);
  // Behind the hand, where one sees it: the hand has come this way.
  const way = from.clone().sub(to);
  group.add(arrow(from.clone().add(way), from, color, 0.002));
  group.userData.handle = grasp.handle;
  return group;
}

class Parts {
  constructor(page) {
    const { result, view } = page;
    this.scene = new THREE.Scene();
    this.handles = result.handles.map((handle, i) => new HandlePart(handle, i, page.handleColor(i)));
    this.grasps = (view.plan ? view.plan.grasps : []).map((grasp) => makeGrasp(grasp, page.handleColor(grasp.handle)));
    const group = (objects) => {
      const made = new THREE.Group();
      if (objects.length) made.add(...objects);
      this.scene.add(made);
      return made;
    };
    this.layers = {
      samples: group(view.samples ? [makeSamples(page)] : []),
      affordances: group(result.affordances.length ? [makeShells(page)] : []),
      handles: group(this.handles.map((part) => part.group)),
      approaches: group(this.handles.map((part) => part.approach)),
      grippers: group(this.grasps),
    };
  }

  /** Shows the handles that `keep` says, and what belongs to them. */
  filter(keep) {
    for (const part of this.handles) part.group.visible = part.approach.visible = keep(part.index);
    for (const grasp of this.grasps) grasp.visible = keep(grasp.userData.handle);
  }

  choose(index) {
    for (const part of this.handles) part.setChosen(part.index === index, index !== null && part.index !== index);
  }

  /** The index of the handle that a ray meets first, or null. */
  pick(ray) {
    const bodies = this.layers.handles.visible ? this.handles.filter(({ group }) => group.visible) : [];
    const hits = ray.intersectObjects(bodies.map(({ body }) => body));
    if (!hits.length) return null;
    return bodies.find(({ body }) => body === hits[0].object).index;
  }

  /** How many of each are shown. */
  shown() {
    const count = (name) => {
      const layer = this.layers[name];
      return layer.visible ? layer.children.filter((child) => child.visible).length : 0;
    };
    const within = (name, number) => (count(name) ? number(this.layers[name].children[0]) : 0);
    return {
      handles: count("handles"),
      approaches: count("approaches"),
      grippers: count("grippers"),
      affordances: within("affordances", (shells) => shells.count),
      samples: within("samples", (samples) => samples.geometry.attributes.position.count),
    };
  }
}
