"use strict";
(() => {
  const $ = (id) => document.getElementById(id);
  const key = JSON.parse($("key").textContent); // names, letters and colours of classes and causes
  const KINDS = { faces: "i", picture: "p", depth: "z", classes: "m", causes: "c" };
  const MODES = { "two-up": "t", blink: "b", swipe: "s", onion: "o" };
  const OVERLAYS = ["none", "facing", "depth complexity", "face size", "wireframe"];
  const FAINT = 0.25; // opacity of the picture beneath classes and causes
  const TINT = 0.65; // opacity of an overlay
  const MOST = 96; // CSS pixels a sample at most
  const POINTS = 12, LETTERS = 16; // CSS pixels a sample from which points and letters are drawn
  const AROUND = 4; // samples on each side in the context zoom
  const BOXES = 12; // clusters that are framed
  const LEAST = 4, DOTS = 20000; // units of a marked sample, at least, unless more than so many are marked
  const PACE = 700; // milliseconds between blinks: well below three flashes a second
  const KEPT = 8; // painted canvases

  // ---------------------------------------------------------------- unpacking

  const ARRAYS = {
    uint8: Uint8Array, uint16: Uint16Array, uint32: Uint32Array, int32: Int32Array, float32: Float32Array,
  };

  function inflated(text) {
    const binary = atob(text);
    const bytes = new Uint8Array(binary.length);
    for (let k = 0; k < binary.length; k++) bytes[k] = binary.charCodeAt(k);
    return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate")));
  }

  /** Undo pack: inflate, then sum the differences along the axes, the last one first. */
  async function unpack({ type, shape, axes, data }) {
    const array = new ARRAYS[type](await inflated(data).arrayBuffer());
    for (const axis of [...axes].reverse()) {
      const stride = axis === 0 ? array.length / shape[0] : 1;
      for (let k = stride; k < array.length; k++) {
        if (axis === 0 || k % shape[1]) array[k] += array[k - stride];
      }
    }
    return array;
  }

  /** Unpack the named entries of an object, the others as they are. */
  async function unpacked(packed, names) {
    const arrays = await Promise.all(names.map((name) => unpack(packed[name])));
    return { ...packed, ...Object.fromEntries(names.map((name, k) => [name, arrays[k]])) };
  }

  /** Places of the bits that are set. */
  function positions(bytes, count) {
    const places = new Uint32Array(count);
    let found = 0;
    for (let k = 0; k < bytes.length; k++) {
      for (let bit = 0; bytes[k] && bit < 8; bit++) if (bytes[k] & (128 >> bit)) places[found++] = 8 * k + bit;
    }
    return places;
  }

  /** What a method shows at every sample, and the samples that have a class or a cause. */
  async function shownBy(packed, like) {
    const names = ["index", "depth", "classes", "causes"];
    const method = await unpacked(packed, ["differs", ...names]);
    const places = positions(method.differs, method.index.length);
    for (const name of names) {
      const whole = places.length ? like[name].slice() : like[name];
      places.forEach((sample, k) => { whole[sample] = method[name][k]; });
      method[name] = whole;
    }
    const marked = [];
    for (let k = 0; k < method.classes.length; k++) if (method.classes[k] || method.causes[k]) marked.push(k);
    method.samples = Uint32Array.from(marked);
    method.clusters = await inflated(packed.clusters).json();
    return method;
  }

  /** The colour of a face, by the rule of hsr.pictures.palette.face_colours. */
  function colourOf(face) {
    if (face < 0) return Array(3).fill(key.neutral);
    const rest = (x) => x - Math.floor(x);
    const hue = 6 * rest(face / key.plastic ** 2), value = 0.55 + 0.4 * rest(face / key.plastic);
    const part = rest(hue);
    const [low, down, up] = [0.5, 1 - 0.5 * part, 1 - 0.5 * (1 - part)].map((share) => share * value);
    const sectors = [[value, up, low], [down, value, low], [low, value, up], [low, down, value], [up, low, value], [value, low, down]];
    return sectors[Math.floor(hue) % 6].map((share) => Math.round(255 * share));
  }

  /** What a person calls a face that is shown. */
  function nameOf(index) {
    const face = scene.faces[index];
    const { name, first, count, faces } = scene.manifest.findLast((object) => object.first <= face) ?? {};
    if (!(face - first < count)) return face === -1 ? "background" : `unknown face ${face}`;
    if (!faces?.length) return `${name}#${face - first}`;
    return faces.length === 1 ? name : `${name}.${faces[face - first]}`;
  }

  async function load(number) {
    const packed = JSON.parse($(`data-${number}`).textContent);
    const drawn = packed.drawn ? ["sizes", "facing", "complexity"] : [];
    const scene = await unpacked(packed, ["faces", "index", "depth", ...drawn]);
    [scene.width, scene.height] = packed.size;
    [scene.edges, scene.hidden] = await Promise.all([packed.edges, packed.hidden].map(
      (edges) => edges ? unpacked(edges, ["points", "ends"]) : { points: [], ends: [] }));
    const none = new Uint8Array(scene.index.length);
    const before = [{ index: scene.index, depth: scene.depth, classes: none, causes: none }];
    for (const method of packed.methods) before.push(await shownBy(method, before[method.like]));
    scene.methods = before.slice(1);
    scene.manifest = await inflated(packed.manifest).json();
    scene.colours = Array.from(scene.faces, colourOf);
    scene.told = await unpack(packed.told);
    scene.picture = $(`picture-${number}`);
    await scene.picture.decode();
    return scene;
  }

  // ---------------------------------------------------------------- what a method shows

  /** The lines of a sample's history, null if it is not in the page. They are told when the first is asked for. */
  async function storyAt(number) {
    const k = lowerBound(scene.told, number);
    scene.telling ??= inflated(scene.stories).json().then(tellings);
    return scene.told[k] === number ? (await scene.telling)[k] : null;
  }

  /** Undo pack_told: each line is a form, with the next row of its columns in its gaps. */
  function tellings({ forms, columns, lines }) {
    const rows = forms.map(() => 0);
    return lines.map((places) => places.map((place) => {
      const [kind, form] = forms[place];
      const row = rows[place]++;
      let gap = 0;
      const text = form.replace(/\{(?::(\+?)\.(\d)g)?\}/g, (_, plus, digits) => figures(columns[place][gap++][row], plus, Number(digits)));
      return { kind, text };
    }));
  }

  /** Write a number as Python does by ".4g" or "+.4g"; texts and whole numbers as they are. */
  function figures(value, plus, digits) {
    if (typeof value === "string" || !digits) return `${value}`;
    const [mantissa, power] = Math.abs(value).toExponential(digits - 1).split("e").map(Number);
    const sign = value < 0 || Object.is(value, -0) ? "-" : plus;
    if (power >= -4 && power < digits) return sign + Number(Math.abs(value).toPrecision(digits));
    return `${sign}${mantissa}e${power < 0 ? "-" : "+"}${String(Math.abs(power)).padStart(2, "0")}`;
  }

  /** Place of the first of ascending numbers that is not less than a number. */
  function lowerBound(numbers, number) {
    let low = 0, high = numbers.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (numbers[middle] < number) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  /** What a method shows at a sample: index of the face, level of the depth, class, cause. */
  function shownAt(method, row, column) {
    const sample = row * scene.width + column;
    return { index: method.index[sample], level: method.depth[sample], kind: method.classes[sample], cause: method.causes[sample] };
  }

  /** A depth to the digits that its level holds. */
  function depthOf(level) {
    const [nearest, farthest] = scene.span;
    return level === key.empty ? "–" : `≈ ${(nearest + (level / key.farthest) * (farthest - nearest)).toPrecision(4)}`;
  }

  const rgb = ([r, g, b]) => `rgb(${r} ${g} ${b})`;

  // ---------------------------------------------------------------- painting samples

  const word = ([r, g, b]) => (0xff000000 | (b << 16) | (g << 8) | r) >>> 0; // as ImageData has it

  /** The overlays that can be drawn: without a view none. */
  const known = () => (scene.drawn ? OVERLAYS : OVERLAYS.slice(0, 1));

  /** Colours of numbers: for each kind of picture a table, and the numbers, those of all or a method's own. */
  function fields() {
    const table = (marks) => Uint32Array.from(marks, (mark) => (mark ? word(mark.colour) : 0));
    return {
      faces: { own: "index", table: Uint32Array.from(scene.colours, word) },
      depth: { own: "depth", table: greys(0, key.farthest) },
      classes: { own: "classes", faint: true, table: table(key.classes) },
      causes: { own: "causes", faint: true, table: table(key.causes) },
      ...(scene.drawn ? overlays() : {}),
    };
  }

  function overlays() {
    const most = Math.max(2, scene.complexity.reduce((a, b) => Math.max(a, b), 0));
    const ramp = (share) => word(key.ramp[Math.round(share * (key.ramp.length - 1))]);
    const greatest = Math.max(1, scene.sizes.reduce((a, b) => Math.max(a, b), 0));
    return {
      facing: { whole: scene.facing, table: Uint32Array.of(0, ...key.facing.map(word)) },
      "depth complexity": { whole: scene.complexity, most, table: Uint32Array.from({ length: 256 }, (_, k) => (k ? ramp(Math.min((k - 1) / (most - 1), 1)) : 0)) },
      "face size": { whole: scene.index, most: greatest, table: Uint32Array.of(0, ...Array.from(scene.sizes, (size) => ramp(size / greatest))) },
    };
  }

  /** Greys of depth levels: light at the nearest of a range, dark at the farthest, no depth black. */
  function greys(nearest, farthest) {
    const table = new Uint32Array(key.empty + 1);
    for (let level = 0; level < key.empty; level++) {
      const share = Math.min(Math.max((level - nearest) / Math.max(farthest - nearest, 1), 0), 1);
      table[level] = word(Array(3).fill(Math.round(255 * (0.95 - 0.75 * share))));
    }
    table[key.empty] = word([0, 0, 0]);
    return table;
  }

  /** A canvas with one pixel a sample; beneath classes and causes lies the picture. */
  function painted(method, name) {
    const id = `${method.name}/${name}`;
    if (canvases.has(id)) return canvases.get(id);
    const { whole, own, faint, table } = scene.fields[name];
    const numbers = whole ?? method[own], pixels = new Uint32Array(numbers.length);
    for (let k = 0; k < pixels.length; k++) pixels[k] = table[numbers[k]];
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [scene.width, scene.height];
    const context = canvas.getContext("2d");
    context.putImageData(new ImageData(new Uint8ClampedArray(pixels.buffer), scene.width), 0, 0);
    if (faint) {
      context.globalAlpha = FAINT;
      context.globalCompositeOperation = "destination-over";
      context.drawImage(scene.picture, 0, 0, scene.width, scene.height);
    }
    canvases.set(id, canvas);
    if (canvases.size > KEPT) canvases.delete(canvases.keys().next().value);
    return canvas;
  }

  // ---------------------------------------------------------------- state

  const dialog = $("inspector");
  const stages = [...dialog.querySelectorAll(".stage")];
  const choices = { scene: $("scene"), mode: $("mode"), kind: $("kind"), overlay: $("overlay") };
  const choosers = [$("method-left"), $("method-right")];
  const loaded = new Map();
  const canvases = new Map();
  let scene = null;
  let mode, kind, overlay;
  let shown = [0, 0]; // places of the methods on the left and on the right
  let sample = { row: 0, column: 0 };
  let cluster = -1;
  let fromBottom = false;
  let blinked = 0;
  let place = { scale: 0, x: 0, y: 0 }; // of the image's corner in each stage, in CSS pixels
  let extent = { width: 0, height: 0 }; // of a stage
  let unit = 1; // thickness of a line in CSS pixels: more on a wall than on a desk

  // ---------------------------------------------------------------- drawing

  let pending = 0;
  function redraw() {
    pending ||= requestAnimationFrame(() => {
      pending = 0;
      stages.forEach(drawStage);
    });
  }

  /** An empty canvas, opaque: nothing beneath it need be blended in. */
  function cleared(canvas) {
    const { clientWidth: width, clientHeight: height } = canvas;
    const ratio = devicePixelRatio;
    if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
      [canvas.width, canvas.height] = [Math.round(width * ratio), Math.round(height * ratio)];
    }
    const context = canvas.getContext("2d", { alpha: false });
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.fillStyle = getComputedStyle(canvas).backgroundColor;
    context.fillRect(0, 0, width, height);
    return context;
  }

  function drawStage(stage, side) {
    if (!scene || !stage.clientWidth) return;
    const context = cleared(stage);
    const share = Number($("share").value);
    const top = mode === "two-up" ? side : mode === "blink" ? blinked : 1;
    if (mode === "swipe" || mode === "onion") drawImage(context, 0, 1);
    context.save();
    if (mode === "swipe") {
      context.beginPath();
      context.rect(share * extent.width, 0, extent.width, extent.height);
      context.clip();
    }
    drawImage(context, top, mode === "onion" ? share : 1);
    context.restore();
    if (mode === "swipe") {
      context.fillStyle = "#111";
      context.fillRect(share * extent.width - unit, 0, 2 * unit, extent.height);
    }
    if (overlay in scene.fields) put(context, painted(scene.methods[scene.base], overlay), TINT);
    if (overlay === "wireframe") drawEdges(context, scene.edges, place, extent);
    if (place.scale >= POINTS) drawPoints(context);
    if (kindOf(top) === "classes" || kindOf(top) === "causes") drawMarks(context, scene.methods[shown[top]]);
    drawCursor(context);
  }

  /** The kind of picture on a side: the reference has no classes and no causes. */
  function kindOf(side) {
    return (kind === "classes" || kind === "causes") && shown[side] === scene.base ? "faces" : kind;
  }

  function drawImage(context, side, opacity) {
    const method = scene.methods[shown[side]];
    const name = kindOf(side);
    put(context, name === "picture" ? scene.picture : painted(method, name), opacity);
  }

  function put(context, image, opacity) {
    context.globalAlpha = opacity;
    context.imageSmoothingEnabled = place.scale < 1; // a sample zoomed in on is a square of one colour
    context.drawImage(image, place.x, place.y, scene.width * place.scale, scene.height * place.scale);
    context.globalAlpha = 1;
  }

  /** Edges of faces, dark with a light rim. */
  function drawEdges(context, { points, ends }, { scale, x, y }, { width, height }) {
    const path = new Path2D();
    const step = scale / key.fine, half = points.length / 2, many = ends.length / 2; // x and y, tails and heads
    for (let k = 0; k < many; k++) {
      const a = ends[k], b = ends[many + k];
      const x0 = x + step * points[a], y0 = y + step * points[half + a];
      const x1 = x + step * points[b], y1 = y + step * points[half + b];
      if (Math.max(x0, x1) < 0 || Math.min(x0, x1) > width || Math.max(y0, y1) < 0 || Math.min(y0, y1) > height) continue;
      path.moveTo(x0, y0);
      path.lineTo(x1, y1);
    }
    if (scale >= 4) {
      context.strokeStyle = "rgb(255 255 255 / .8)";
      context.lineWidth = 3 * unit;
      context.stroke(path);
    }
    context.strokeStyle = "#111";
    context.lineWidth = unit;
    context.stroke(path);
  }

  /** Rows and columns of the samples in view, the last ones not included. */
  function inView() {
    const range = (offset, length, count) => [
      Math.max(Math.floor(-offset / place.scale), 0), Math.min(Math.ceil((length - offset) / place.scale), count)];
    return { rows: range(place.y, extent.height, scene.height), columns: range(place.x, extent.width, scene.width) };
  }

  const dot = (context, x, y) => context.fillRect(x - unit, y - unit, 2 * unit, 2 * unit);

  function drawPoints(context) {
    const { rows, columns } = inView();
    context.fillStyle = "rgb(0 0 0 / .55)";
    for (let row = rows[0]; row < rows[1]; row++) {
      for (let column = columns[0]; column < columns[1]; column++) {
        dot(context, place.x + (column + 0.5) * place.scale, place.y + (row + 0.5) * place.scale);
      }
    }
  }

  /** Frames around clusters, and close by the letters of classes or causes. */
  function drawMarks(context, method) {
    context.strokeStyle = "#777";
    context.lineWidth = unit;
    const margin = 4 * unit;
    for (const [, , row0, column0, row1, column1] of method.clusters.slice(0, BOXES)) {
      context.strokeRect(place.x + column0 * place.scale - margin, place.y + row0 * place.scale - margin,
        (column1 - column0) * place.scale + 2 * margin, (row1 - row0) * place.scale + 2 * margin);
    }
    const marks = key[kind], values = method[kind];
    const least = LEAST * unit;
    if (place.scale < least && method.samples.length <= DOTS) {
      method.samples.forEach((number) => {
        if (!marks[values[number]]) return;
        const row = Math.floor(number / scene.width), column = number % scene.width;
        context.fillStyle = rgb(marks[values[number]].colour);
        context.fillRect(place.x + (column + 0.5) * place.scale - least / 2, place.y + (row + 0.5) * place.scale - least / 2, least, least);
      });
    }
    if (place.scale < LETTERS) return;
    const { rows } = inView();
    const end = lowerBound(method.samples, rows[1] * scene.width);
    context.font = `600 ${0.55 * place.scale}px system-ui, sans-serif`;
    context.textAlign = "center";
    context.textBaseline = "middle";
    for (let k = lowerBound(method.samples, rows[0] * scene.width); k < end; k++) {
      const mark = marks[values[method.samples[k]]];
      if (!mark) continue;
      const row = Math.floor(method.samples[k] / scene.width), column = method.samples[k] % scene.width;
      context.fillStyle = mark.colour[0] + 2 * mark.colour[1] > 380 ? "#111" : "#fff";
      context.fillText(mark.letter, place.x + (column + 0.5) * place.scale, place.y + (row + 0.5) * place.scale);
    }
  }

  function drawCursor(context) {
    const side = Math.max(place.scale, 9 * unit);
    const x = place.x + (sample.column + 0.5) * place.scale - side / 2;
    const y = place.y + (sample.row + 0.5) * place.scale - side / 2;
    for (const [colour, width] of [["#111", 4], ["#fff", 2]]) {
      context.strokeStyle = colour;
      context.lineWidth = width * unit;
      context.strokeRect(x, y, side, side);
    }
  }

  // ---------------------------------------------------------------- moving about

  function moveTo(next) {
    place = next;
    $("scale").textContent = `${Number(place.scale.toPrecision(3))}×`;
    redraw();
  }

  /** Put a point of the image into the middle of the stages. */
  function centre(row, column, scale) {
    moveTo({ scale, x: extent.width / 2 - column * scale, y: extent.height / 2 - row * scale });
  }

  function fit() {
    centre(scene.height / 2, scene.width / 2, Math.min(extent.width / scene.width, extent.height / scene.height));
  }

  /** Zoom about a point of the stage, which stays where it is. */
  function zoom(factor, x, y) {
    const scale = Math.min(Math.max(place.scale * factor, 1 / 16), MOST);
    const ratio = scale / place.scale;
    moveTo({ scale, x: x - (x - place.x) * ratio, y: y - (y - place.y) * ratio });
  }

  function zoomAtSample(factor) {
    zoom(factor, place.x + (sample.column + 0.5) * place.scale, place.y + (sample.row + 0.5) * place.scale);
  }

  /** Choose a sample, and bring it into view if it is not. */
  function pick(row, column) {
    sample = {
      row: Math.min(Math.max(row, 0), scene.height - 1),
      column: Math.min(Math.max(column, 0), scene.width - 1),
    };
    const { rows, columns } = inView();
    const visible = sample.row >= rows[0] && sample.row < rows[1] && sample.column >= columns[0] && sample.column < columns[1];
    if (!visible) centre(sample.row + 0.5, sample.column + 0.5, place.scale);
    tell();
    redraw();
    remember();
  }

  /** Go to the next or previous cluster of the method on the right. */
  function nextCluster(step) {
    const { clusters } = scene.methods[shown[1]];
    if (!clusters.length) return;
    cluster = (Math.max(cluster, step > 0 ? -1 : 0) + step + clusters.length) % clusters.length;
    const [row, column, row0, column0, row1, column1] = clusters[cluster];
    const scale = Math.min(extent.width / (column1 - column0), extent.height / (row1 - row0)) / 3;
    centre(row + 0.5, column + 0.5, Math.min(Math.max(scale, 1), MOST / 2));
    pick(row, column);
  }

  /** Stretch the greys of depths over those in view, or over all of them again. */
  function normalise() {
    const { rows, columns } = inView();
    let nearest = key.farthest, farthest = 0;
    for (let row = rows[0]; row < rows[1]; row++) {
      for (let column = columns[0]; column < columns[1]; column++) {
        const level = scene.depth[row * scene.width + column];
        if (level === key.empty) continue;
        nearest = Math.min(nearest, level);
        farthest = Math.max(farthest, level);
      }
    }
    const { depth } = scene.fields;
    const narrowed = !depth.range && farthest > nearest;
    depth.range = narrowed ? [nearest, farthest] : null;
    depth.table = greys(...(depth.range ?? [0, key.farthest]));
    for (const method of scene.methods) canvases.delete(`${method.name}/depth`);
    update();
  }

  /** Name the sample in the page's address, a little later: browsers count such changes. */
  let remembering = 0;
  function remember() {
    clearTimeout(remembering);
    remembering = setTimeout(() => {
      const { row: y, column: x } = sample;
      history.replaceState(null, "", `#${new URLSearchParams({ scene: scene.name, method: scene.methods[shown[1]].name, x, y })}`);
    }, 200);
  }

  // ---------------------------------------------------------------- words

  function element(tag, name, ...content) {
    const made = document.createElement(tag);
    if (name) made.className = name;
    made.append(...content);
    return made;
  }

  function swatch(colour) {
    const made = element("span", "swatch");
    made.style.background = rgb(colour);
    return made;
  }

  function position(row, column) {
    return `column ${column}, row ${fromBottom ? `${scene.height - 1 - row} from the bottom` : row}`;
  }

  /** Fill the panel with what is known of the sample. */
  function tell() {
    const { row, column } = sample;
    $("position").textContent = position(row, column);
    shown.forEach((method, side) => drawContext($(side ? "context-right" : "context-left"), scene.methods[method]));
    tellStory();
    $("methods").replaceChildren(...scene.methods.map((method, k) => {
      const { index, level, kind, cause } = shownAt(method, row, column);
      const found = [key.classes[kind]?.label ?? "same", key.causes[cause]?.label].filter(Boolean).join(", ");
      const judged = !scene.judged ? "" : k === scene.base ? "reference" : found;
      const line = element("tr", shown.includes(k) ? "chosen" : "",
        element("th", "", method.name), element("td", "", swatch(scene.colours[index]), nameOf(index)),
        element("td", "number", depthOf(level)), element("td", cause || [1, 2, 3].includes(kind) ? "differs" : "quiet", judged));
      line.firstChild.scope = "row";
      line.addEventListener("click", () => choose(1, k));
      line.addEventListener("contextmenu", (event) => {
        event.preventDefault();
        choose(0, k);
      });
      return line;
    }));
  }

  /** Tell the history of the sample once it is unpacked, unless another has been chosen by then. */
  async function tellStory() {
    const [open, chosen] = [scene, sample];
    const story = await storyAt(sample.row * scene.width + sample.column);
    if (scene !== open || sample !== chosen) return;
    $("story").replaceChildren(...(story ? storyOf(story) : [element("p", "quiet", ...withoutStory())]));
  }

  function storyOf(lines) {
    const told = (...kinds) => lines.filter(({ kind }) => kinds.includes(kind));
    const list = (name, items) => element("ul", name, ...items);
    const faces = [];
    for (const { kind, text } of told("owner", "face", "verdict")) {
      if (kind !== "verdict") {
        faces.push(element("li", kind, element("span", "line", text), list("", [])));
        continue;
      }
      const face = faces.at(-1), won = text.startsWith("won:");
      const wrong = won ? face.className !== "owner" : /^(passed over|missed)/.test(text);
      face.lastChild.append(element("li", `verdict ${wrong ? "wrong" : won ? "right" : ""}`, text));
    }
    const missed = told("missed").map(({ text }) => element("li", "", text));
    return [
      ...told("headline").map(({ text }) => element("p", "headline", text)),
      list("faces", faces),
      ...(missed.length ? [element("p", "", key.missed), list("missed", missed)] : []),
      list("sentences", told("sentence").map(({ text }, k) => element("li", shown.includes(k) ? "chosen" : "", text))),
    ];
  }

  function withoutStory() {
    const { told, wanted, untold, command } = scene;
    if (untold) return [`No histories: ${untold}.`];
    const bound = told.length < wanted ? ` Of the ${wanted} samples that differ or touch one that does, ${told.length} have theirs.` : "";
    const asked = element("code", "", command.replace("X,Y", `${sample.column},${sample.row}`));
    return [`The history of this sample is not in the page.${bound}`, ...(command ? [" Ask for it: ", asked] : [])];
  }

  /** The samples around the chosen one as a method shows them, with the edges of faces. */
  function drawContext(canvas, method) {
    const context = cleared(canvas);
    const side = canvas.clientWidth / (2 * AROUND + 1);
    const from = { row: sample.row - AROUND, column: sample.column - AROUND };
    for (let down = 0; down <= 2 * AROUND; down++) {
      for (let across = 0; across <= 2 * AROUND; across++) {
        const row = from.row + down, column = from.column + across;
        if (row < 0 || column < 0 || row >= scene.height || column >= scene.width) continue;
        context.fillStyle = rgb(scene.colours[shownAt(method, row, column).index]);
        context.fillRect(across * side, down * side, side + 0.5, side + 0.5);
      }
    }
    const there = { scale: side, x: -from.column * side, y: -from.row * side };
    const size = { width: canvas.clientWidth, height: canvas.clientWidth };
    context.setLineDash([3 * unit, 3 * unit]);
    drawEdges(context, scene.hidden, there, size);
    context.setLineDash([]);
    drawEdges(context, scene.edges, there, size);
    context.fillStyle = "#111";
    for (let k = 0; k < (2 * AROUND + 1) ** 2; k++) {
      const x = ((k % (2 * AROUND + 1)) + 0.5) * side, y = (Math.floor(k / (2 * AROUND + 1)) + 0.5) * side;
      dot(context, x, y);
    }
    context.lineWidth = 2 * unit;
    for (const [colour, inset] of [["#111", 0], ["#fff", 2 * unit]]) {
      context.strokeStyle = colour;
      context.strokeRect(AROUND * side + inset, AROUND * side + inset, side - 2 * inset, side - 2 * inset);
    }
    canvas.setAttribute("aria-label", `${method.name} around ${position(sample.row, sample.column)}`);
    canvas.nextElementSibling.textContent = method.name;
  }

  /** Say what the colours in the stages mean. */
  function legend() {
    const method = scene.methods[shown[1]];
    const reference = scene.methods[scene.base].name;
    const item = (colour, text) => element("span", "item", swatch(colour), text);
    const counts = (name) => {
      const tally = new Map();
      for (const sample of method.samples) tally.set(method[name][sample], (tally.get(method[name][sample]) ?? 0) + 1);
      const items = key[name].map((mark, k) => mark && tally.has(k) && item(mark.colour, `${mark.letter} ${mark.label} ${tally.get(k)}`)).filter(Boolean);
      return items.length ? items : [`${method.name}: nothing differs from ${reference}`];
    };
    const [nearest, farthest] = scene.fields.depth.range ?? [0, key.farthest];
    const size = (power) => `${2 ** (key.smallest + power)} px`;
    const ends = (low, high) => [item(key.ramp[0], low), item(key.ramp.at(-1), high)];
    const words = {
      faces: () => ["Colours only tell faces apart."],
      picture: () => [scene.drawn ? `Shaded, as ${reference} sees it.` : `The faces that ${reference} shows.`],
      depth: () => [`Light ${depthOf(nearest)}, dark ${depthOf(farthest)}.`],
      classes: () => counts("classes"),
      causes: () => counts("causes"),
      none: () => [],
      facing: () => [item(key.facing[0], "front"), item(key.facing[1], "back")],
      "depth complexity": () => ends("1 face", `${scene.fields["depth complexity"].most} faces on the line of sight`),
      "face size": () => ends(size(0), size(scene.fields["face size"].most)),
      wireframe: () => [`Edges of the faces that ${reference} shows.`],
    };
    $("legend").replaceChildren(...words[kind](), " ", ...words[overlay]());
  }

  // ---------------------------------------------------------------- choosing

  /** Bring everything up to date with the state. */
  function update() {
    Object.entries({ mode, kind, overlay }).forEach(([name, value]) => { choices[name].value = value; });
    choosers.forEach((chooser, side) => { chooser.value = shown[side]; });
    stages.forEach((stage, side) => {
      const names = mode === "two-up" ? [shown[side]] : shown;
      stage.setAttribute("aria-label", `${names.map((k) => scene.methods[k].name).join(" and ")}: ${kind}`);
    });
    dialog.classList.toggle("single", mode !== "two-up");
    $("shared").hidden = mode !== "swipe" && mode !== "onion";
    $("origin").setAttribute("aria-pressed", fromBottom);
    tell();
    legend();
    redraw();
    remember();
  }

  function choose(side, method) {
    if (method < 0 || method >= scene.methods.length) return;
    shown[side] = method;
    if (side === 1) cluster = -1;
    update();
  }

  /** Show another way to compare; the same way again leads back to two pictures side by side. */
  function compareBy(name) {
    mode = mode === name ? "two-up" : name;
    blinked = 0;
    update();
  }

  function blink() {
    if (mode !== "blink") return;
    blinked = 1 - blinked;
    redraw();
  }
  if (!matchMedia("(prefers-reduced-motion: reduce)").matches) setInterval(blink, PACE);

  /** Open a scene at a method's sample: if none is named its largest cluster, or else a sample that has a history. */
  async function open(number, wanted, row, column) {
    [mode, kind, overlay] = ["two-up", "faces", "none"];
    canvases.clear();
    clearTimeout(remembering);
    scene = null;
    if (!dialog.open) dialog.showModal();
    dialog.setAttribute("aria-busy", "true");
    if (!loaded.has(number)) loaded.set(number, load(number));
    scene = await loaded.get(number);
    scene.fields ??= fields();
    dialog.removeAttribute("aria-busy");
    choices.scene.value = number;
    choices.overlay.replaceChildren(...known().map((name) => new Option(name, name)));
    for (const chooser of choosers) {
      chooser.replaceChildren(...scene.methods.map(({ name }, k) => new Option(k < 9 ? `${k + 1}  ${name}` : name, k)));
    }
    const method = scene.methods.findIndex(({ name }) => name === wanted);
    shown = [scene.base, method < 0 ? scene.base : method];
    [cluster, sample] = [-1, { row: 0, column: 0 }]; // the last scene may have been larger
    measure();
    fit();
    update();
    const { clusters, samples } = scene.methods[shown[1]];
    const told = samples.find((number) => scene.told[lowerBound(scene.told, number)] === number); // ties form no clusters
    const at = (number) => number !== undefined && [Math.floor(number / scene.width), number % scene.width];
    const first = clusters[0] ?? at(told);
    if (row !== undefined) {
      pick(row, column);
    } else if (first) {
      kind = "classes";
      pick(first[0], first[1]);
      update();
    } else {
      pick(...(at(scene.told[0]) || [scene.height >> 1, scene.width >> 1]));
    }
    dialog.focus();
  }

  /** Open what the page's address names: #scene=NAME&method=NAME&x=COLUMN&y=ROW. */
  function openAddress() {
    const named = new URLSearchParams(location.hash.slice(1));
    if (!named.has("scene")) return;
    const option = [...choices.scene.options].find(({ text }) => text === named.get("scene"));
    $("lost").textContent = option ? "" : `This report has no scene named ${named.get("scene")}.`;
    const [x, y] = ["x", "y"].map((name) => Number.parseInt(named.get(name), 10));
    if (option) open(option.value, named.get("method"), ...(Number.isNaN(x + y) ? [] : [y, x]));
  }

  // ---------------------------------------------------------------- hands

  /** Keep the middle of the image where it is when the stages change size. */
  function measure() {
    const { clientWidth: width, clientHeight: height } = stages[0];
    place = { ...place, x: place.x + (width - extent.width) / 2, y: place.y + (height - extent.height) / 2 };
    extent = { width, height };
    unit = parseFloat(getComputedStyle(document.documentElement).fontSize) / 16;
  }
  new ResizeObserver(() => {
    measure();
    if (scene) tell();
    redraw();
  }).observe(stages[0]);

  function sampleUnder(stage, event) {
    const { left, top } = stage.getBoundingClientRect();
    return [Math.floor((event.clientY - top - place.y) / place.scale), Math.floor((event.clientX - left - place.x) / place.scale)];
  }

  /** Fingers on a stage: where their middle is, and how far apart they are. */
  function grip(fingers) {
    const [first, second = first] = fingers.values();
    return {
      x: (first.x + second.x) / 2, y: (first.y + second.y) / 2,
      apart: Math.hypot(second.x - first.x, second.y - first.y),
    };
  }

  /** Move the image with the fingers, and zoom it by what their distance has changed. */
  function drag(before, now) {
    moveTo({ ...place, x: place.x + now.x - before.x, y: place.y + now.y - before.y });
    if (before.apart && now.apart) zoom(now.apart / before.apart, now.x, now.y);
  }

  for (const stage of stages) {
    const fingers = new Map(); // or the mouse: where each pointer that is down was last
    let travelled = 0;
    const at = (event) => {
      const { left, top } = stage.getBoundingClientRect();
      return { x: event.clientX - left, y: event.clientY - top };
    };
    stage.addEventListener("wheel", (event) => {
      event.preventDefault();
      const { x, y } = at(event);
      zoom(Math.exp(-event.deltaY / 400), x, y);
    }, { passive: false });
    stage.addEventListener("pointerdown", (event) => {
      stage.setPointerCapture(event.pointerId);
      if (!fingers.size) travelled = 0;
      fingers.set(event.pointerId, at(event));
    });
    stage.addEventListener("pointermove", (event) => {
      if (fingers.has(event.pointerId)) {
        const before = grip(fingers);
        fingers.set(event.pointerId, at(event));
        const now = grip(fingers);
        travelled += Math.abs(now.x - before.x) + Math.abs(now.y - before.y) + Math.abs(now.apart - before.apart);
        drag(before, now);
        return;
      }
      if (!scene) return;
      const [row, column] = sampleUnder(stage, event);
      const inside = row >= 0 && column >= 0 && row < scene.height && column < scene.width;
      const method = scene.methods[shown[mode === "two-up" ? stages.indexOf(stage) : 1]];
      $("hover").textContent = inside ? `${position(row, column)}: ${nameOf(shownAt(method, row, column).index)}` : "";
    });
    for (const end of ["pointerup", "pointercancel"]) {
      stage.addEventListener(end, (event) => {
        fingers.delete(event.pointerId);
        if (end === "pointerup" && !fingers.size && travelled < 4) pick(...sampleUnder(stage, event));
      });
    }
  }

  const [modes, kinds] = [MODES, KINDS].map((names) => Object.keys(names));
  const fill = (select, names) => select.append(...names.map((name) => new Option(name, name)));
  fill(choices.mode, modes);
  fill(choices.kind, kinds);
  choices.scene.addEventListener("change", () => open(choices.scene.value));
  choices.mode.addEventListener("change", () => { mode = choices.mode.value; update(); });
  choices.kind.addEventListener("change", () => { kind = choices.kind.value; update(); });
  choices.overlay.addEventListener("change", () => { overlay = choices.overlay.value; update(); });
  choosers.forEach((chooser, side) => chooser.addEventListener("change", () => choose(side, Number(chooser.value))));
  $("share").addEventListener("input", redraw);
  $("go").addEventListener("submit", (event) => {
    event.preventDefault();
    const [column, row] = $("go-to").value.split(/[\s,;]+/).map(Number);
    if (Number.isInteger(row) && Number.isInteger(column)) pick(fromBottom ? scene.height - 1 - row : row, column);
    dialog.focus();
  });

  function slide(step) {
    $("share").value = Number($("share").value) + step;
    redraw();
  }

  const actions = {
    "+": () => zoomAtSample(1.5),
    "=": () => zoomAtSample(1.5),
    "-": () => zoomAtSample(1 / 1.5),
    0: () => centre(sample.row + 0.5, sample.column + 0.5, 1),
    f: fit,
    j: () => choose(1, shown[1] + 1),
    k: () => choose(1, shown[1] - 1),
    J: () => choose(0, shown[0] + 1),
    K: () => choose(0, shown[0] - 1),
    "]": () => nextCluster(1),
    "[": () => nextCluster(-1),
    n: normalise,
    v: () => { overlay = known()[(known().indexOf(overlay) + 1) % known().length]; update(); },
    y: () => { fromBottom = !fromBottom; update(); },
    g: () => $("go-to").select(),
    " ": blink,
    ",": () => slide(-0.05),
    ".": () => slide(0.05),
    "?": () => $("help").showModal(),
    Escape: () => (document.activeElement === $("go-to") ? dialog.focus() : dialog.close()),
  };
  for (const name of kinds) actions[KINDS[name]] = () => { kind = name; update(); };
  for (const name of modes) actions[MODES[name]] = () => compareBy(name);
  const metrics = { ArrowLeft: -1, ArrowRight: 1 };
  const arrows = { ArrowUp: [-1, 0], ArrowDown: [1, 0], ArrowLeft: [0, -1], ArrowRight: [0, 1] };

  dialog.addEventListener("keydown", (event) => {
    if (event.ctrlKey && event.key in metrics && scene) {
      kind = kinds.at((kinds.indexOf(kind) + metrics[event.key]) % kinds.length);
      event.preventDefault();
      update();
      return;
    }
    const typing = ["SELECT", "INPUT"].includes(event.target.tagName) || (event.key === " " && event.target.tagName === "BUTTON");
    if (!scene || event.ctrlKey || event.metaKey || event.altKey || (typing && event.key !== "Escape")) return;
    const digit = /^Digit([1-9])$/.exec(event.code);
    if (digit) {
      choose(event.shiftKey ? 0 : 1, Number(digit[1]) - 1);
    } else if (event.key in arrows) {
      const stride = event.shiftKey ? 10 : 1;
      const [down, across] = arrows[event.key];
      pick(sample.row + stride * down, sample.column + stride * across);
    } else if (event.key in actions) {
      actions[event.key]();
    } else {
      return;
    }
    event.preventDefault();
  });
  for (const button of dialog.querySelectorAll("[data-key]")) {
    button.addEventListener("click", () => actions[button.dataset.key]());
  }
  for (const button of document.querySelectorAll(".thumb")) {
    button.addEventListener("click", () => open(button.dataset.scene, button.dataset.method));
  }
  dialog.addEventListener("close", () => {
    clearTimeout(remembering);
    history.replaceState(null, "", "#");
  });
  addEventListener("hashchange", openAddress);
  openAddress();
})();
