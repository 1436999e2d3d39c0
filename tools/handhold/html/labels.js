// Numbers beside the handles: buttons over the picture, each with a line to its handle, none over another.

/** To the right of the handle, and below it; the first that is free. */
const kLabelPlaces = [[0, -1], [1, 0], [-1, 0], [0, 1], [1, -1], [-1, -1], [1, 1], [-1, 1]];

class Labels {
  constructor(handles, onChoose) {
    this.holder = element("labels");
    this.leaders = element("leaders");
    this.visible = true;
    this.labels = handles.map((part) => {
      const { confidence } = part.handle;
      const button = make("button", "label", "", [
        make("b", "", String(part.index + 1)), make("span", "", confidence.toFixed(2))]);
      button.type = "button";
      button.style.setProperty("--color", part.color);
      button.setAttribute("aria-label", `Handle ${part.index + 1}, confidence ${confidence.toFixed(2)}`);
      button.addEventListener("click", () => onChoose(part.index));
      const line = document.createElementNS("http://www.w3.org/2000/svg", "line");
      line.setAttribute("stroke", part.color);
      this.holder.append(button);
      this.leaders.append(line);
      return { part, button, line, place: 0, width: button.offsetWidth || 60, height: button.offsetHeight || 24 };
    });
  }

  choose(index) {
    for (const { part, button } of this.labels) {
      button.classList.toggle("chosen", part.index === index);
      button.setAttribute("aria-pressed", String(part.index === index));
    }
  }

  /** The part's box in the picture (px), or null where its centre is not in it. */
  box(part, camera, width, height) {
    const point = part.center.clone().project(camera);
    if (Math.abs(point.x) > 1 || Math.abs(point.y) > 1 || Math.abs(point.z) > 1) return null;
    const x = (point.x + 1) * width / 2, y = (1 - point.y) * height / 2;
    const distance = camera.position.distanceTo(part.center);
    const radius = (part.radius / distance) * camera.projectionMatrix.elements[5] * height / 2;
    const box = { x, y, left: x, right: x, top: y, bottom: y };
    for (const end of part.line) {
      point.copy(end).project(camera);
      if (Math.abs(point.z) > 1) continue;
      const px = (point.x + 1) * width / 2, py = (1 - point.y) * height / 2;
      box.left = Math.min(box.left, px - radius);
      box.right = Math.max(box.right, px + radius);
      box.top = Math.min(box.top, py - radius);
      box.bottom = Math.max(box.bottom, py + radius);
    }
    // Of a part that fills the picture the middle is what counts.
    box.left = Math.max(box.left, x - width / 4);
    box.right = Math.min(box.right, x + width / 4);
    box.top = Math.max(box.top, y - height / 4);
    box.bottom = Math.min(box.bottom, y + height / 4);
    return box;
  }

  /** Puts them where their handles are now. */
  place(camera, width, height) {
    const { offsetLeft: left, offsetTop: top, offsetWidth, offsetHeight } = element("toolbar");
    const taken = [{ left, top, right: left + offsetWidth, bottom: top + offsetHeight }];
    const overlap = (a, b, room) => a.left < b.right + room && b.left < a.right + room && a.top < b.bottom + room &&
      b.top < a.bottom + room;
    const parts = this.labels.map(({ part }) => {
      return this.visible && part.group.visible ? this.box(part, camera, width, height) : null;
    });
    for (const [i, label] of this.labels.entries()) {
      const part = parts[i];
      label.shown = part !== null;
      label.button.hidden = !label.shown;
      label.line.style.display = label.shown ? "" : "none";
      if (!part) continue;
      const { x, y } = part;
      const box = (k) => {
        const [right, down] = kLabelPlaces[k];
        const half = { x: label.width / 2, y: label.height / 2 };
        const cx = right < 0 ? part.left - half.x - 12 : right > 0 ? part.right + half.x + 12 : x;
        const cy = down < 0 ? part.top - half.y - 12 : down > 0 ? part.bottom + half.y + 12 : y;
        return { left: cx - half.x, top: cy - half.y, right: cx + half.x, bottom: cy + half.y };
      };
      const inside = (b) => b.left > 2 && b.top > 2 && b.right < width - 2 && b.bottom < height - 2;
      const free = (b) => inside(b) && !taken.some((other) => overlap(b, other, 3));
      const clear = (b) => free(b) && !parts.some((other, k) => k !== i && other && overlap(b, other, 0));
      // Where it is already, as long as nothing is there: labels that jump cannot be read.
      const places = [label.place, ...kLabelPlaces.keys()];
      label.place = [clear, free].map((test) => places.find((k) => test(box(k)))).find((k) => k !== undefined) || 0;
      const b = box(label.place);
      taken.push(b);
      label.button.style.transform = `translate(${Math.round(b.left)}px, ${Math.round(b.top)}px)`;
      const ends = { x1: x, y1: y, x2: THREE.Math.clamp(x, b.left, b.right), y2: THREE.Math.clamp(y, b.top, b.bottom) };
      for (const [name, value] of Object.entries(ends)) label.line.setAttribute(name, value.toFixed(1));
    }
  }

  shown() {
    return this.labels.filter(({ shown }) => shown).length;
  }
}
