// What the program wrote into the page. The files of this folder share one scope; embed.cmake joins them in the order
// that tools/CMakeLists.txt gives.

const element = (id) => document.getElementById(id);

/** A new element with a class, a text and children; texts are never parsed as HTML. */
function make(tag, className = "", text = "", children = []) {
  const made = document.createElement(tag);
  if (className) made.className = className;
  if (text) made.textContent = text;
  made.append(...children);
  return made;
}

const vector = (numbers) => new THREE.Vector3(...numbers);

/** Bytes of a base64 text; the text is dropped, for it may be large. */
function takeBytes(id) {
  const holder = element(id);
  const text = holder.textContent;
  holder.remove();
  if (Uint8Array.fromBase64) return Uint8Array.fromBase64(text);
  const binary = atob(text);
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; ++i) bytes[i] = binary.charCodeAt(i);
  return bytes;
}

/** Rows of `count` numbers with a fourth one, 0: graphics cards want rows of a multiple of four bytes. */
function padded(numbers, count) {
  const rows = new numbers.constructor(4 * count);
  for (let i = 0; i < count; ++i) {
    rows[4 * i] = numbers[3 * i];
    rows[4 * i + 1] = numbers[3 * i + 1];
    rows[4 * i + 2] = numbers[3 * i + 2];
  }
  return rows;
}

function readPage() {
  const resultText = element("result").textContent;
  const result = JSON.parse(resultText);
  const view = JSON.parse(element("view-data").textContent);
  const points = view.cloud.points;
  const colors = takeBytes("colors");
  return {
    result,
    resultText,
    view,
    /** 65535ths of the cloud's box, four numbers a point. */
    positions: padded(new Uint16Array(takeBytes("positions").buffer), points),
    colors: colors.length ? padded(colors, points) : null,
    samples: padded(new Uint16Array(takeBytes("samples").buffer), view.samples),
    steps: takeBytes("steps"),
    handleColor: (i) => view.handle_colors[i % view.handle_colors.length],
  };
}
