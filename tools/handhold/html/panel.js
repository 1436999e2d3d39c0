// What stands beside the picture: handles, numbers, layers, funnel, keys.

const kLayers = [
  { name: "cloud", title: "Cloud", key: "C" },
  { name: "shading", title: "Shading", key: "E" },
  { name: "handles", title: "Handles", key: "H" },
  { name: "labels", title: "Labels", key: "L" },
  { name: "approaches", title: "Ways to approach", key: "V" },
  { name: "grippers", title: "Planned grasps", key: "G" },
  { name: "affordances", title: "Affordances", key: "A" },
  { name: "samples", title: "Samples", key: "S" },
];

const kKeys = [
  ["Drag, one finger", "turn"],
  ["Right button, Shift-drag, two fingers", "move"],
  ["Wheel, pinch", "zoom to the pointer"],
  ["Click, tap", "a handle's numbers"],
  ["Double click, double tap", "turn about that point"],
  ["1 – 9 · N · P", "choose a handle · next · previous"],
  ["F", "look at the chosen handle"],
  ["Esc", "choose none, close"],
  ["R · T", "as the camera saw it · from above"],
  ["Arrows · Shift-arrows · + −", "turn · move · zoom"],
  ["[ · ]", "smaller, larger points"],
  ["M", "next colour of the points"],
  ["B · D · O", "background · save picture · panel"],
];

const kStepTitles = {
  too_few_points: "too few points", flat: "flat", curvature_low: "too little curved", concave: "hollow",
  circle_wide: "too wide", circle_narrow: "too narrow", poor_fit: "no cylinder fits", no_gap: "no room for fingers",
  shell_empty: "shell empty", cut: "out of time", affordances: "affordances", not_aligned: "not aligned",
  unconfirmed: "not borne out", too_short: "too short", low_confidence: "low confidence", in_handles: "in handles",
};

const kDegrees = 180 / Math.PI;
const grouped = (n) => String(n).replace(/\B(?=(\d{3})+$)/g, ",");
const counted = (n, what) => `${n === 0 ? "no" : grouped(n)} ${what}${n === 1 ? "" : "s"}`;
const millimetres = (x, digits = 1) => `${(1000 * x).toFixed(digits)} mm`;
const places = (v) => `${v.map((x) => (1000 * x).toFixed(1)).join(", ")} mm`;
const direction = (v) => v.map((x) => x.toFixed(3)).join(", ");

/** Rows of name and text for a handle. */
function numbersOf(handle, index, view) {
  const rows = [
    ["Confidence", handle.confidence.toFixed(3)],
    ["Centre", places(handle.center)],
    ["Axis", direction(handle.axis)],
    ["Approach", direction(handle.approach)],
    ["Radius", millimetres(handle.radius)],
    ["Length", millimetres(handle.length)],
  ];
  if (handle.path) rows.push(["Shape", `curved, ${handle.path.length} points`]);
  if (handle.arc) {
    rows.push(["Seen around", `${(handle.arc * kDegrees).toFixed(0)}°`]);
    rows.push(["Residual", millimetres(handle.residual, 2)]);
    rows.push(["Normals off by", `${(handle.normal_error * kDegrees).toFixed(1)}°`]);
    rows.push(["Free for fingers", `${(100 * handle.observed_free).toFixed(0)} %`]);
  }
  rows.push(["Affordances", String(handle.affordances.length)]);
  const { plan } = view;
  if (plan) {
    const { R, t } = plan.T_base_cloud, c = handle.center;
    const inBase = [0, 1, 2].map((k) => R[3 * k] * c[0] + R[3 * k + 1] * c[1] + R[3 * k + 2] * c[2] + t[k]);
    rows.push([`Centre in ${plan.base}`, places(inBase)]);
    const grasp = plan.grasps.find((one) => one.handle === index);
    const rejection = plan.rejected.find((one) => one.handle === index);
    if (grasp) {
      rows.push(["Grasp", `${plan.tip}, after ${grasp.time.toFixed(1)} s`]);
      rows.push(["Fingers open to", millimetres(grasp.opening)]);
      rows.push(["Part between them", millimetres(grasp.width)]);
    } else {
      rows.push(["Grasp", rejection ? `none: ${rejection.reason}` : "not looked at"]);
    }
  }
  return rows;
}

class Panel {
  /** @param on  choose(index), filter(threshold), layer(name, shown), coloring(name), pointSize(factor), focus() */
  constructor(page, on) {
    this.page = page;
    this.on = on;
    const { result, view } = page;
    element("name").textContent = view.name;
    element("summary").textContent = [
      counted(result.handles.length, "handle"), counted(result.cloud.finite, "point"),
      counted(result.funnel.samples, "sample")].join(" · ");
    this.addNotes();
    this.addHandles();
    this.addLayers();
    this.addFunnel("Of the samples", view.sample_steps, result.funnel.samples);
    if (result.funnel.affordances) {
      this.addFunnel("Of the affordances", view.affordance_steps, result.funnel.affordances);
    }
    this.addHelp();
    element("focus").addEventListener("click", () => on.focus());
    element("copy").addEventListener("click", () => this.copy());
    element("download").addEventListener("click", () => {
      save(new Blob([page.resultText], { type: "application/json" }), `${view.name}.json`);
    });
  }

  addNotes() {
    const { result, view } = this.page;
    const notes = [];
    if (result.status === "deadline") notes.push("Cut by its deadline: there may be more.");
    if (!result.handles.length) {
      notes.push("No handles. The bars below tell where the samples ended, and what would help.");
    }
    if (view.cloud.step > 1) notes.push(`Every ${grouped(view.cloud.step)}th point is shown.`);
    if (view.cloud.far) notes.push(`${counted(view.cloud.far, "point")} far away from all others: not shown.`);
    if (view.plan) {
      const { grasps, rejected, arm, tip } = view.plan;
      notes.push(`${counted(grasps.length, "grasp")} planned for ${tip} (${arm}), ${rejected.length} rejected.`);
    }
    element("notes").append(...notes.map((note) => make("li", "", note)));
    element("notes").hidden = notes.length === 0;
  }

  addHandles() {
    const { result, view, handleColor } = this.page;
    const marks = new Map(result.handles.map((handle, i) => [i, handle.path ? "curved" : ""]));
    if (view.plan) {
      for (const { handle } of view.plan.grasps) marks.set(handle, "grasp");
      for (const { handle } of view.plan.rejected) marks.set(handle, "rejected");
    }
    this.rows = result.handles.map((handle, i) => {
      const bar = make("span", "bar", "", [make("i")]);
      bar.firstChild.style.width = `${(100 * handle.confidence).toFixed(1)}%`;
      const size = `⌀ ${(2000 * handle.radius).toFixed(0)} × ${(1000 * handle.length).toFixed(0)} mm`;
      const button = make("button", "handle", "", [
        make("b", "", String(i + 1)), make("span", "size", size),
        make("span", "mark", marks.get(i)), bar,
        make("span", "confidence", handle.confidence.toFixed(2))]);
      button.type = "button";
      button.style.setProperty("--color", handleColor(i));
      button.addEventListener("click", () => this.on.choose(i));
      const row = make("li", "", "", [button]);
      element("handles").append(row);
      return row;
    });
    const slider = element("threshold");
    // What the search left out below that is not in the page.
    slider.min = Math.min(Math.floor(100 * view.min_confidence) / 100, 0.99);
    slider.value = slider.min;
    slider.disabled = result.handles.length === 0;
    slider.addEventListener("input", () => this.on.filter(Number(slider.value)));
  }

  showThreshold(threshold, shown) {
    const all = this.page.result.handles.length;
    element("threshold-value").textContent = threshold.toFixed(2);
    element("handles-count").textContent = shown.length === all ? `${all}` : `${shown.length} of ${all}`;
    this.rows.forEach((row, i) => { row.hidden = !shown.includes(i); });
  }

  choose(index) {
    this.chosen = index;
    this.rows.forEach((row, i) => row.firstChild.setAttribute("aria-pressed", String(i === index)));
    const details = element("details");
    details.hidden = index === null;
    if (index === null) return;
    const { result, view, handleColor } = this.page;
    element("details-title").textContent = `Handle ${index + 1}`;
    details.style.setProperty("--color", handleColor(index));
    element("numbers").replaceChildren(...numbersOf(result.handles[index], index, view).flatMap(
      ([name, text]) => [make("dt", "", name), make("dd", "", text)]));
  }

  async copy() {
    const button = element("copy");
    try {
      await navigator.clipboard.writeText(JSON.stringify(this.page.result.handles[this.chosen]));
      button.textContent = "Copied";
    } catch (error) {
      button.textContent = "The browser forbids it";
    }
    setTimeout(() => { button.textContent = "Copy as JSON"; }, 1500);
  }

  addLayers() {
    const { result, view } = this.page;
    const counts = {
      affordances: result.affordances.length, samples: view.samples, handles: result.handles.length,
      grippers: view.plan ? view.plan.grasps.length : 0, cloud: view.cloud.points,
    };
    this.boxes = {};
    for (const { name, title, key } of kLayers) {
      if (name === "grippers" && !view.plan) continue;
      const box = make("input");
      box.type = "checkbox";
      box.id = `layer-${name}`;
      box.addEventListener("change", () => this.on.layer(name, box.checked));
      const text = make("span", "", title);
      if (name in counts) text.append(make("span", "count", grouped(counts[name])));
      element("layers").append(make("li", "", "", [make("label", "row", "", [box, text, make("kbd", "", key)])]));
      this.boxes[name] = box;
    }
    const size = element("point-size");
    size.addEventListener("input", () => this.on.pointSize(Number(size.value)));
    const coloring = element("coloring");
    coloring.addEventListener("change", () => this.on.coloring(coloring.value));
  }

  showLayer(name, shown) {
    if (this.boxes[name]) this.boxes[name].checked = shown;
  }
  showColorings(colorings, chosen) {
    element("coloring").replaceChildren(...colorings.map(({ name, title }) => new Option(title, name)));
    element("coloring").value = chosen;
  }
  showPointSize(factor) {
    element("point-size").value = factor;
    element("point-size-value").textContent = `× ${factor.toFixed(2)}`;
  }

  addFunnel(title, steps, whole) {
    const colors = new Map(this.page.view.step_colors.map(({ name, color }) => [name, color]));
    const list = make("ul", "funnel");
    for (const { name, count, what, settings, advice } of steps) {
      if (!count) continue;
      const share = (100 * count) / whole;
      const bar = make("span", "bar", "", [make("i")]);
      bar.firstChild.style.width = `${share.toFixed(1)}%`;
      const summary = make("summary", "", "", [
        make("span", "step", kStepTitles[name] || name), bar, make("span", "number", grouped(count))]);
      const text = `${grouped(count)} of ${grouped(whole)} (${share.toFixed(1)} %) ${what}` +
        `${settings ? ` (${settings})` : ""}.`;
      const row = make("details", "", "", [summary, make("p", "", text)]);
      if (advice) row.append(make("p", "advice", `What would change it: ${advice}.`));
      row.style.setProperty("--color", colors.get(name) || (name === "in_handles" ? "#ff9e1c" : "#8b929c"));
      list.append(make("li", "", "", [row]));
    }
    element("funnel").append(make("h3", "", title), list);
  }

  addHelp() {
    const keys = [...kKeys, ["Layers", kLayers.map(({ key, title }) => `${key} ${title.toLowerCase()}`).join(" · ")]];
    element("help-keys").append(make("dl", "", "", keys.flatMap(
      ([key, meaning]) => [make("dt", "", key), make("dd", "", meaning)])));
    element("help-button").addEventListener("click", () => element("help").showModal());
  }
}

/** Offers a file to the person who looks at the page. */
function save(blob, name) {
  const link = make("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}
