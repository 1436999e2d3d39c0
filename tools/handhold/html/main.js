// The page as a whole: what is chosen and shown, when it is drawn, and what the keys do.

const kBackgrounds = { dark: "#14171c", light: "#f4f5f7" };
const root = document.documentElement;
const page = readPage();

/** Of everything, for the camera's far plane and the zoom. */
function boundsOf({ lower, size }) {
  const half = vector(size).multiplyScalar(0.5);
  return { center: vector(lower).add(half), radius: Math.max(half.length(), 0.05) };
}

class App {
  constructor() {
    this.chosen = null;
    this.coarse = this.slow = false;
    this.hidden = new Set(["affordances", "samples"]);
    if (page.view.plan) this.hidden.add("approaches");
    this.panel = new Panel(page, {
      choose: (index) => this.choose(index === this.chosen ? null : index),
      filter: (threshold) => this.filter(threshold),
      layer: (name, shown) => this.setLayer(name, shown),
      coloring: (name) => this.setColoring(name),
      pointSize: (factor) => this.setPointSize(factor),
      focus: () => this.focus(),
    });
    this.canvas = element("canvas");
    this.renderer = this.makeRenderer();
    if (this.renderer) this.makeScene();
    this.filter(Number(element("threshold").min));
    for (const { name } of kLayers) this.setLayer(name, !this.hidden.has(name));
    this.addButtons();
    window.addEventListener("keydown", (event) => this.key(event));
    if (!this.renderer) return;
    new ResizeObserver(() => this.resize()).observe(element("view"));
    this.resize();
  }

  makeRenderer() {
    const wishes = { antialias: true, alpha: false, powerPreference: "high-performance" };
    const context = this.canvas.getContext("webgl2", wishes);
    if (!context) {
      root.dataset.state = "no-webgl";
      element("message").textContent = "This browser shows no 3-D: it has no WebGL 2, or it is switched off " +
        "(hardware acceleration in the settings). The numbers beside are complete.";
      element("message").hidden = false;
      return null;
    }
    this.canvas.addEventListener("webglcontextlost", (event) => {
      event.preventDefault();
      element("message").textContent = "The graphics card has dropped the picture; reload the page if it stays away.";
      element("message").hidden = false;
    });
    this.canvas.addEventListener("webglcontextrestored", () => {
      element("message").hidden = true;
      this.resize();
    });
    const renderer = new THREE.WebGLRenderer({ canvas: this.canvas, context });
    renderer.autoClear = false;
    return renderer;
  }

  makeScene() {
    const { view } = page;
    this.orbit = new OrbitCamera(view.start, boundsOf(view.cloud));
    this.cloud = new CloudLayer(page, this.orbit.up);
    this.parts = new Parts(page);
    this.labels = new Labels(this.parts.handles, (index) => this.choose(index));
    this.panel.showColorings(this.cloud.colorings, this.cloud.coloring);
    this.panel.showPointSize(1);
    this.setTheme(root.dataset.theme);
    this.orbit.attach(this.canvas, {
      moved: () => this.draw(),
      tap: (x, y) => this.tap(x, y),
      doubleTap: (x, y) => this.pivot(x, y),
    });
  }

  addButtons() {
    const on = (id, action) => element(id).addEventListener("click", action);
    on("toggle-panel", () => this.togglePanel());
    on("theme", () => this.setTheme(root.dataset.theme === "dark" ? "light" : "dark"));
    const narrow = window.matchMedia("(max-width: 760px)").matches;
    this.togglePanel(!narrow);
    if (!this.renderer) {
      for (const id of ["reset", "top", "save", "focus"]) element(id).disabled = true;
      element("shown").hidden = true;
      return;
    }
    on("reset", () => this.move((orbit) => orbit.reset()));
    on("top", () => this.move((orbit) => orbit.lookFromTop()));
    on("save", () => this.savePicture());
  }

  // ---- What is shown ----

  choose(index) {
    this.chosen = index;
    this.panel.choose(index);
    if (!this.renderer) return;
    this.parts.choose(index);
    this.labels.choose(index);
    this.draw();
  }

  filter(threshold) {
    const lowest = Number(element("threshold").min);
    // At its lowest end the slider keeps everything: its steps are coarser than the numbers.
    const keep = (i) => threshold <= lowest || page.result.handles[i].confidence >= threshold;
    const shown = page.result.handles.map((_, i) => i).filter(keep);
    this.panel.showThreshold(threshold, shown);
    if (this.renderer) this.parts.filter(keep);
    if (this.chosen !== null && !keep(this.chosen)) this.choose(null);
    this.draw();
  }

  setLayer(name, shown) {
    if (shown) this.hidden.delete(name);
    else this.hidden.add(name);
    this.panel.showLayer(name, shown);
    if (!this.renderer) return;
    if (name === "cloud") this.cloud.points.visible = shown;
    else if (name === "shading") this.cloud.shaded = shown;
    else if (name === "labels") this.labels.visible = shown;
    else this.parts.layers[name].visible = shown;
    this.draw();
  }

  setColoring(name) {
    this.cloud.setColoring(name);
    this.panel.showColorings(this.cloud.colorings, name);
    this.draw();
  }

  setPointSize(factor) {
    this.cloud.pointSize = THREE.Math.clamp(factor, 0.25, 4);
    this.panel.showPointSize(this.cloud.pointSize);
    this.draw();
  }

  setTheme(theme) {
    root.dataset.theme = theme;
    element("theme").textContent = theme === "dark" ? "Light" : "Dark";
    if (!this.renderer) return;
    this.renderer.setClearColor(kBackgrounds[theme], 1);
    this.draw();
  }

  togglePanel(open = document.body.classList.contains("closed")) {
    document.body.classList.toggle("closed", !open);
    element("toggle-panel").setAttribute("aria-expanded", String(open));
  }

  // ---- The camera, and what is under the pointer ----

  move(how) {
    how(this.orbit);
    this.draw();
  }

  focus() {
    if (this.chosen === null || !this.renderer) return;
    const { center, handle } = this.parts.handles[this.chosen];
    this.move((orbit) => orbit.lookAt(center, orbit.distanceFor(1.6 * (handle.length + 2 * handle.radius))));
  }

  /** From pixels to -1..1. */
  toPicture(x, y) {
    return new THREE.Vector2((2 * x) / this.width - 1, 1 - (2 * y) / this.height);
  }

  tap(x, y) {
    const ray = new THREE.Raycaster();
    ray.setFromCamera(this.toPicture(x, y), this.orbit.camera);
    this.choose(this.parts.pick(ray));
  }

  pivot(x, y) {
    const { x: right, y: up } = this.toPicture(x, y);
    const point = this.cloud.pick(right, up, this.orbit.camera, 16 / this.height);
    if (point) this.move((orbit) => orbit.lookAt(point));
  }

  // ---- Drawing: only when something has changed ----

  resize() {
    const { clientWidth, clientHeight } = element("view");
    this.width = Math.max(clientWidth, 1);
    this.height = Math.max(clientHeight, 1);
    const ratio = Math.min(window.devicePixelRatio || 1, 2) * (this.coarse ? 0.5 : 1);
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(this.width, this.height, false);
    this.cloud.resize(this.width, this.height, ratio);
    this.orbit.resize(this.width, this.height);
    this.draw();
  }

  setCoarse(coarse) {
    if (this.coarse === coarse) return;
    this.coarse = coarse;
    this.cloud.setCoarse(coarse);
    this.resize();
  }

  draw() {
    if (!this.renderer || this.requested || !this.width) return;
    this.requested = true;
    root.dataset.still = "false";
    requestAnimationFrame((time) => this.frame(time));
  }

  frame(time) {
    this.requested = false;
    // After a rest the first step is one of a usual frame.
    const seconds = this.lastFrame ? (time - this.lastFrame) / 1000 : 1 / 60;
    const moving = this.orbit.update(Math.min(seconds, 0.25));
    // Where there is no graphics card, a moving picture has fewer pixels and points.
    if (moving && seconds > 0.08) this.slow = true;
    this.setCoarse(moving && this.slow);
    this.render();
    this.lastFrame = moving ? time : 0;
    if (moving) this.draw();
    root.dataset.still = String(!this.requested);
  }

  render() {
    const { renderer, orbit: { camera } } = this;
    renderer.setRenderTarget(null);
    renderer.clear();
    const points = this.cloud.draw(renderer, camera);
    renderer.render(this.parts.scene, camera);
    this.labels.place(camera, this.width, this.height);
    if (root.dataset.state === "loading") {
      renderer.getContext().finish();
      root.dataset.state = "ready";
      root.dataset.loadMs = Math.round(performance.now());
    }
    // What tests, and curious people, ask.
    root.dataset.drawn = JSON.stringify({ points, labels: this.labels.shown(), ...this.parts.shown() });
  }

  savePicture() {
    this.render();
    this.canvas.toBlob((blob) => save(blob, `${page.view.name}.png`));
  }

  // ---- Keys ----

  key(event) {
    const { key, target } = event;
    if (event.ctrlKey || event.metaKey || event.altKey || element("help").open) return;
    const own = target.tagName === "SELECT" || (target.type === "range" && /^(Arrow|Page|Home|End)/.test(key));
    if (own) return;
    const action = this.actionOf(key, event.shiftKey);
    if (!action) return;
    event.preventDefault();
    action();
  }

  actionOf(key, shift) {
    const lower = key.toLowerCase();
    if (key === "?") return () => element("help").showModal();
    if (key === "Escape") return () => this.choose(null);
    if (lower === "o") return () => this.togglePanel();
    if (lower === "b") return () => this.setTheme(root.dataset.theme === "dark" ? "light" : "dark");
    if (/^[1-9]$/.test(key)) return () => this.chooseShown(() => Number(key) - 1);
    if (lower === "n") return () => this.chooseNext(1);
    if (lower === "p") return () => this.chooseNext(-1);
    if (!this.renderer) return null;
    const layer = kLayers.find((one) => one.key.toLowerCase() === lower);
    if (layer) return () => this.setLayer(layer.name, this.hidden.has(layer.name));
    const step = shift ? 40 : 0.12;
    const go = shift ? (right, down) => this.move((orbit) => orbit.move(right * step, down * step))
      : (right, down) => this.move((orbit) => orbit.turn(right * step, down * step));
    const actions = {
      arrowleft: () => go(-1, 0), arrowright: () => go(1, 0), arrowup: () => go(0, -1), arrowdown: () => go(0, 1),
      "+": () => this.move((orbit) => orbit.zoom(0.85)), "=": () => this.move((orbit) => orbit.zoom(0.85)),
      "-": () => this.move((orbit) => orbit.zoom(1 / 0.85)),
      r: () => this.move((orbit) => orbit.reset()), t: () => this.move((orbit) => orbit.lookFromTop()),
      f: () => this.focus(), d: () => this.savePicture(),
      "[": () => this.setPointSize(this.cloud.pointSize / 1.2),
      "]": () => this.setPointSize(this.cloud.pointSize * 1.2),
      m: () => {
        const names = this.cloud.colorings.map(({ name }) => name);
        this.setColoring(names[(names.indexOf(this.cloud.coloring) + 1) % names.length]);
      },
    };
    return actions[lower] || null;
  }

  chooseShown(which) {
    const index = which();
    if (this.panel.rows[index] && !this.panel.rows[index].hidden) this.choose(index);
  }

  chooseNext(step) {
    const shown = this.panel.rows.map((_, i) => i).filter((i) => !this.panel.rows[i].hidden);
    if (!shown.length) return;
    const at = shown.indexOf(this.chosen);
    this.choose(shown[at < 0 ? (step > 0 ? 0 : shown.length - 1) : (at + step + shown.length) % shown.length]);
  }
}

new App();
