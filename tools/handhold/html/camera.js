// A camera on a sphere about a target: turned, moved and zoomed by mouse, fingers and keys, with damping.

const kPitchLimit = 1.55;  // rad; over the pole, right and left would change places

class OrbitCamera {
  /**
   * @param start   of the view data: eye, target, down, up, angle
   * @param bounds  sphere around everything (m)
   */
  constructor(start, bounds) {
    this.camera = new THREE.PerspectiveCamera(50, 1, 0.01, 100);
    this.bounds = bounds;
    this.angle = start.angle;
    this.up = vector(start.up).normalize();
    const target = vector(start.target);
    const back = vector(start.eye).sub(target);
    const distance = back.length();
    // From above, what is below in the picture is in front.
    let front = back.clone().addScaledVector(this.up, -back.dot(this.up));
    if (front.length() < 0.05 * distance) {
      front = vector(start.down);
      front.addScaledVector(this.up, -front.dot(this.up));
    }
    this.front = front.normalize();
    this.side = new THREE.Vector3().crossVectors(this.up, this.front);
    const pitch = Math.asin(THREE.Math.clamp(back.dot(this.up) / distance, -1, 1));
    this.home = { target, yaw: 0, pitch: THREE.Math.clamp(pitch, -kPitchLimit, kPitchLimit), distance };
    this.still = window.matchMedia("(prefers-reduced-motion: reduce)").matches;
    this.goal = this.copy(this.home);
    this.now = this.copy(this.home);
    this.place();
  }

  copy(state) {
    return { ...state, target: state.target.clone() };
  }

  resize(width, height) {
    this.height = height;
    this.camera.aspect = width / height;
    // What a picture of 4 : 3 shows is to be seen in a narrow one, too.
    const half = Math.tan(this.angle / 2) * Math.max(1, 4 / 3 / this.camera.aspect);
    this.camera.fov = THREE.Math.radToDeg(2 * Math.atan(half));
    this.place();
  }

  reset() {
    this.goal = this.copy(this.home);
    // The short way round.
    this.goal.yaw += 2 * Math.PI * Math.round(this.now.yaw / (2 * Math.PI));
  }
  lookFromTop() {
    this.goal.pitch = kPitchLimit;
  }
  lookAt(point, distance) {
    this.goal.target.copy(point);
    if (distance) this.goal.distance = distance;
  }

  /** From where something of that size (m) is as high as the picture. */
  distanceFor(size) {
    return size / (2 * Math.tan(THREE.Math.degToRad(this.camera.fov) / 2));
  }

  turn(right, down) {
    this.goal.yaw -= right;
    this.goal.pitch = THREE.Math.clamp(this.goal.pitch + down, -kPitchLimit, kPitchLimit);
  }
  /** By pixels in the plane of the target. */
  move(right, down) {
    const scale = this.pixelSize();
    const { right: x, up: y } = this.axes();
    this.goal.target.addScaledVector(x, -right * scale).addScaledVector(y, down * scale);
  }
  /** @param x, y  px from the middle of the picture, to the right and down: what is there stays there */
  zoom(factor, x = 0, y = 0) {
    const least = 0.002 * this.bounds.radius, most = 20 * this.bounds.radius;
    const distance = THREE.Math.clamp(this.goal.distance * factor, least, most);
    const applied = distance / this.goal.distance;
    this.goal.distance = distance;
    this.move(-x * (1 - applied), -y * (1 - applied));
  }

  pixelSize() {
    return (2 * this.now.distance * Math.tan(THREE.Math.degToRad(this.camera.fov) / 2)) / this.height;
  }
  axes() {
    const matrix = this.camera.matrixWorld;
    return {
      right: new THREE.Vector3().setFromMatrixColumn(matrix, 0),
      up: new THREE.Vector3().setFromMatrixColumn(matrix, 1),
    };
  }

  /** @param seconds  since the last frame. Returns whether the camera has moved. */
  update(seconds) {
    const { now, goal } = this;
    const share = this.still ? 1 : 1 - Math.exp(-14 * seconds);
    const away = Math.abs(goal.yaw - now.yaw) + Math.abs(goal.pitch - now.pitch) +
      Math.abs(Math.log(goal.distance / now.distance)) + goal.target.distanceTo(now.target) / now.distance;
    if (away === 0) return false;
    if (away < 1e-4) {
      this.now = this.copy(goal);
    } else {
      now.yaw += share * (goal.yaw - now.yaw);
      now.pitch += share * (goal.pitch - now.pitch);
      now.distance *= Math.pow(goal.distance / now.distance, share);
      now.target.lerp(goal.target, share);
    }
    this.place();
    return true;
  }

  place() {
    const { camera, now } = this;
    const across = Math.cos(now.pitch) * now.distance;
    camera.position.copy(now.target)
      .addScaledVector(this.front, across * Math.cos(now.yaw))
      .addScaledVector(this.side, across * Math.sin(now.yaw))
      .addScaledVector(this.up, Math.sin(now.pitch) * now.distance);
    camera.up.copy(this.up);
    camera.lookAt(now.target);
    camera.near = Math.max(0.02 * now.distance, 1e-4);
    camera.far = 2 * camera.near + camera.position.distanceTo(this.bounds.center) + this.bounds.radius;
    camera.updateProjectionMatrix();
    camera.updateMatrixWorld();
  }

  /**
   * Takes the mouse and fingers on an element.
   * @param on  moved(), tap(x, y), doubleTap(x, y): px from the element's upper left corner
   */
  attach(target, on) {
    const pointers = new Map();
    let travelled = 0, lastTap = { time: -1000, x: 0, y: 0 };
    const place = (event) => {
      const box = target.getBoundingClientRect();
      return { x: event.clientX - box.left, y: event.clientY - box.top };
    };
    const spread = () => {
      const [a, b] = [...pointers.values()];
      return { x: (a.x + b.x) / 2, y: (a.y + b.y) / 2, size: Math.max(1, Math.hypot(a.x - b.x, a.y - b.y)) };
    };
    target.addEventListener("pointerdown", (event) => {
      target.setPointerCapture(event.pointerId);
      if (pointers.size === 0) travelled = 0;
      const moves = event.button === 1 || event.button === 2 || event.shiftKey || event.ctrlKey || event.metaKey;
      pointers.set(event.pointerId, { ...place(event), moves });
    });
    target.addEventListener("pointermove", (event) => {
      const before = pointers.get(event.pointerId);
      if (!before) return;
      const old = pointers.size === 2 ? spread() : before;
      const now = { ...place(event), moves: before.moves };
      travelled += Math.hypot(now.x - before.x, now.y - before.y);
      pointers.set(event.pointerId, now);
      if (pointers.size === 2) {
        const { width, height } = target.getBoundingClientRect();
        const both = spread();
        this.zoom(old.size / both.size, both.x - width / 2, both.y - height / 2);
        this.move(both.x - old.x, both.y - old.y);
      } else if (pointers.size === 1 && before.moves) {
        this.move(now.x - old.x, now.y - old.y);
      } else if (pointers.size === 1) {
        this.turn((now.x - old.x) * 0.006, (now.y - old.y) * 0.006);
      }
      on.moved();
    });
    const release = (event) => {
      const pointer = pointers.get(event.pointerId);
      pointers.delete(event.pointerId);
      if (!pointer || pointers.size > 0 || event.type !== "pointerup" || travelled > 6 || pointer.moves) return;
      const { x, y } = place(event);
      const again = event.timeStamp - lastTap.time < 350 && Math.hypot(x - lastTap.x, y - lastTap.y) < 20;
      lastTap = { time: again ? -1000 : event.timeStamp, x, y };
      if (again) on.doubleTap(x, y);
      else on.tap(x, y);
    };
    target.addEventListener("pointerup", release);
    target.addEventListener("pointercancel", release);
    target.addEventListener("contextmenu", (event) => event.preventDefault());
    target.addEventListener("wheel", (event) => {
      event.preventDefault();
      const { width, height } = target.getBoundingClientRect();
      const { x, y } = place(event);
      const lines = event.deltaMode === 0 ? event.deltaY / 16 : event.deltaY;
      this.zoom(Math.exp(THREE.Math.clamp(lines, -20, 20) * 0.025), x - width / 2, y - height / 2);
      on.moved();
    }, { passive: false });
  }
}
