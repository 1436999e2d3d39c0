// The cloud: all points in one draw call, and the shading that lets one see shape where there is no colour: light from
// above by the normals that the depth image has, and eye-dome lighting: a point is darker, the further its neighbours
// in the picture lie in front of it.

const kColorings = [
  { name: "camera", title: "Camera" },
  { name: "plain", title: "Gray" },
  { name: "depth", title: "Distance" },
  { name: "height", title: "Height" },
];

const kPointVertex = `
uniform vec3 lower, size;
uniform float spacing, viewHeight, least;
uniform int coloring;
uniform vec3 eye, up;
uniform vec2 depths, heights;
attribute vec3 color;
varying vec3 vColor;

// Dark blue, green, yellow: evenly brighter, also for those who do not see red.
vec3 ramp(float t) {
  t = clamp(t, 0.0, 1.0);
  vec3 a = vec3(0.23, 0.18, 0.50), b = vec3(0.13, 0.53, 0.58), c = vec3(0.36, 0.77, 0.40), d = vec3(0.98, 0.91, 0.25);
  return t < 0.33 ? mix(a, b, t / 0.33) : t < 0.66 ? mix(b, c, (t - 0.33) / 0.33) : mix(c, d, (t - 0.66) / 0.34);
}

void main() {
  vec3 place = lower + position * size;
  vec4 p = modelViewMatrix * vec4(place, 1.0);
  gl_Position = projectionMatrix * p;
  gl_PointSize = clamp(spacing * viewHeight * 0.5 * projectionMatrix[1][1] / -p.z, least, 48.0);
  float near = 1.0 - clamp((distance(place, eye) - depths.x) / (depths.y - depths.x), 0.0, 1.0);
  if (coloring == 0) vColor = color;
  else if (coloring == 1) vColor = mix(vec3(0.40, 0.45, 0.52), vec3(0.74, 0.74, 0.73), near);
  else if (coloring == 2) vColor = ramp(near);
  else vColor = ramp((dot(place, up) - heights.x) / (heights.y - heights.x));
}`;

const kPointFragment = `
varying vec3 vColor;
void main() {
  vec2 p = gl_PointCoord - 0.5;
  if (dot(p, p) > 0.25) discard;
  gl_FragColor = vec4(vColor, 1.0);
}`;

const kPictureVertex = `
varying vec2 at;
void main() {
  at = uv;
  gl_Position = vec4(position.xy, 0.0, 1.0);
}`;

const kPictureFragment = `
uniform sampler2D picture, depth;
uniform vec2 pixel;
uniform vec2 slope;
uniform float near, far, strength, lamp;
varying vec2 at;
float distanceAt(vec2 p) {
  float z = texture2D(depth, p).x;
  return z >= 1.0 ? -1.0 : near * far / (far - z * (far - near));
}
vec3 placeAt(vec2 p) {
  float z = distanceAt(p);
  return vec3((2.0 * p - 1.0) * slope * z, -z);
}
// Along the surface: to the side that goes on more evenly, for on the other one something may end.
vec3 along(vec3 here, vec2 step) {
  vec3 a = placeAt(at + step) - here, b = here - placeAt(at - step);
  return abs(a.z) < abs(b.z) ? a : b;
}
void main() {
  float z = texture2D(depth, at).x;
  if (z >= 1.0) discard;
  float here = distanceAt(at), hidden = 0.0;
  for (int i = 0; i < 8; ++i) {
    float angle = 0.785398 * float(i);
    float there = distanceAt(at + 1.3 * pixel * vec2(cos(angle), sin(angle)));
    // Beside the cloud there is nothing in front; a sensor's noise is no shape.
    if (there != -1.0) hidden += clamp(log2(here / there) - 0.002, 0.0, 0.1);
  }
  vec3 place = placeAt(at);
  vec3 right = vec3(0.0), above = vec3(0.0);
  for (int i = 1; i < 5; ++i) {
    right += along(place, vec2(3.0 * float(i) * pixel.x, 0.0));
    above += along(place, vec2(0.0, 3.0 * float(i) * pixel.y));
  }
  vec3 normal = normalize(cross(right, above));
  float light = mix(1.0, 0.5 + 0.6 * max(dot(normal, vec3(0.3, 0.62, 0.72)), 0.0), lamp);
  gl_FragColor = vec4(texture2D(picture, at).rgb * light * exp(-strength * hidden), 1.0);
  gl_FragDepthEXT = z;
}`;

/** How far neighbouring points are apart (m), if they covered the small cubes evenly that they are in. */
function pointSpacing(positions, count, size) {
  const kCells = 96;
  const longest = Math.max(...size, 1e-9), cell = longest / kCells;
  const seen = new Uint8Array(kCells ** 3);
  const factors = size.map((side) => (side / longest) * (kCells - 1) / 65535);
  let occupied = 0;
  for (let i = 0; i < count; ++i) {
    const x = Math.floor(positions[4 * i] * factors[0]), y = Math.floor(positions[4 * i + 1] * factors[1]);
    const index = (x * kCells + y) * kCells + Math.floor(positions[4 * i + 2] * factors[2]);
    occupied += 1 - seen[index];
    seen[index] = 1;
  }
  return cell * Math.sqrt(occupied / Math.max(count, 1));
}

class CloudLayer {
  constructor(page, up) {
    const { cloud, start } = page.view;
    this.count = cloud.points;
    this.lower = vector(cloud.lower);
    this.size = vector(cloud.size);
    this.positions = page.positions;
    this.pointSize = 1;
    this.shaded = true;
    this.spacing = pointSpacing(page.positions, this.count, cloud.size);
    this.colors = page.colors;
    this.fine = { geometry: this.geometry(1), spacing: this.spacing };
    const eye = vector(start.eye);
    this.material = new THREE.ShaderMaterial({
      vertexShader: kPointVertex,
      fragmentShader: kPointFragment,
      uniforms: {
        lower: { value: this.lower },
        size: { value: this.size },
        spacing: { value: 0 },
        viewHeight: { value: 1 },
        least: { value: 1 },
        coloring: { value: 0 },
        eye: { value: eye },
        up: { value: up },
        depths: { value: this.middleRange((point) => point.distanceTo(eye)) },
        heights: { value: this.middleRange((point) => point.dot(up)) },
      },
    });
    this.colorings = kColorings.filter(({ name }) => name !== "camera" || page.colors);
    this.setColoring(this.colorings[0].name);
    this.points = new THREE.Points(this.fine.geometry, this.material);
    this.shown = this.fine;
    this.points.frustumCulled = false;
    this.scene = new THREE.Scene();
    this.scene.add(this.points);

    this.shading = new THREE.ShaderMaterial({
      vertexShader: kPictureVertex,
      fragmentShader: kPictureFragment,
      uniforms: {
        picture: { value: null },
        depth: { value: null },
        pixel: { value: new THREE.Vector2() },
        slope: { value: new THREE.Vector2() },
        lamp: { value: 0 },
        near: { value: 0 },
        far: { value: 0 },
        strength: { value: 0 },
      },
      depthFunc: THREE.AlwaysDepth,
    });
    const square = new THREE.Mesh(new THREE.PlaneBufferGeometry(2, 2), this.shading);
    square.frustumCulled = false;
    this.picture = new THREE.Scene();
    this.picture.add(square);
    this.flat = new THREE.OrthographicCamera(-1, 1, 1, -1, 0, 1);
  }

  /** Of every step-th point. */
  geometry(step) {
    const every = (rows) => {
      if (step === 1) return rows;
      const count = Math.ceil(this.count / step), chosen = new rows.constructor(4 * count);
      for (let i = 0; i < count; ++i) chosen.set(rows.subarray(4 * step * i, 4 * step * i + 4), 4 * i);
      return chosen;
    };
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(every(this.positions), 4, true));
    if (this.colors) geometry.setAttribute("color", new THREE.BufferAttribute(every(this.colors), 4, true));
    return geometry;
  }

  /** Fewer and larger points, for machines on which all are too many to be moved. */
  setCoarse(coarse) {
    if (coarse && !this.few) {
      const step = Math.ceil(this.count / 50000);
      this.few = { geometry: this.geometry(step), spacing: this.spacing * Math.sqrt(step) };
    }
    this.shown = coarse ? this.few : this.fine;
    this.points.geometry = this.shown.geometry;
  }

  point(i, to = new THREE.Vector3()) {
    const p = this.positions;
    return to.set(p[4 * i], p[4 * i + 1], p[4 * i + 2]).divideScalar(65535).multiply(this.size).add(this.lower);
  }

  /** What nearly all points have between the two, as a Vector2. */
  middleRange(measure) {
    const values = [], step = Math.max(1, Math.floor(this.count / 5000)), point = new THREE.Vector3();
    for (let i = 0; i < this.count; i += step) values.push(measure(this.point(i, point)));
    values.sort((a, b) => a - b);
    const low = values[Math.floor(0.02 * (values.length - 1))] || 0;
    const high = values[Math.floor(0.98 * (values.length - 1))] || 0;
    return new THREE.Vector2(low, Math.max(high, low + 1e-3));
  }

  setColoring(name) {
    this.coloring = name;
    this.material.uniforms.coloring.value = kColorings.findIndex((one) => one.name === name);
  }

  /** @param ratio  pixels of the screen to one of CSS */
  resize(width, height, ratio) {
    if (this.target) this.target.dispose();
    this.target = new THREE.WebGLRenderTarget(width * ratio, height * ratio, {
      minFilter: THREE.NearestFilter,
      magFilter: THREE.NearestFilter,
      stencilBuffer: false,
    });
    this.target.depthTexture = new THREE.DepthTexture(width * ratio, height * ratio, THREE.FloatType);
    const { uniforms } = this.shading;
    uniforms.picture.value = this.target.texture;
    uniforms.depth.value = this.target.depthTexture;
    uniforms.pixel.value.set(1 / width, 1 / height);
    this.material.uniforms.viewHeight.value = height * ratio;
    this.material.uniforms.least.value = 1.2 * ratio;
  }

  /** Into the empty picture of the renderer, with depth. Returns how many points were drawn. */
  draw(renderer, camera) {
    if (!this.points.visible) return 0;
    this.material.uniforms.spacing.value = 1.7 * this.shown.spacing * this.pointSize;
    renderer.setRenderTarget(this.target);
    renderer.clear();
    renderer.render(this.scene, camera);
    const drawn = renderer.info.render.points;
    renderer.setRenderTarget(null);
    const { uniforms } = this.shading;
    uniforms.near.value = camera.near;
    uniforms.far.value = camera.far;
    uniforms.slope.value.set(1 / camera.projectionMatrix.elements[0], 1 / camera.projectionMatrix.elements[5]);
    // What has colours of its own has light and shadow in them.
    uniforms.lamp.value = this.shaded && this.coloring !== "camera" ? 1 : 0;
    uniforms.strength.value = this.shaded ? 5 : 0;
    renderer.render(this.picture, this.flat);
    return drawn;
  }

  /** The point that is seen at a place of the picture (-1..1), or null. */
  pick(x, y, camera, reach) {
    const matrix = new THREE.Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse);
    const point = new THREE.Vector3();
    let best = -1, nearest = Infinity;
    for (let i = 0; i < this.count; ++i) {
      this.point(i, point).applyMatrix4(matrix);
      if (point.z > 1 || point.z >= nearest) continue;
      if (Math.hypot((point.x - x) * camera.aspect, point.y - y) > reach) continue;
      nearest = point.z;
      best = i;
    }
    return best < 0 ? null : this.point(best);
  }
}
