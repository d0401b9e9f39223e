"use strict";
(() => {
  const lab = JSON.parse(document.getElementById("lab").textContent);
  const SVG = "http://www.w3.org/2000/svg";
  const KINDS = { picture: "p", faces: "i", depth: "z", difference: "m" };
  const MAX_SCALE = 64;

  // ---------------------------------------------------------------- pictures

  /** Fill an element of class "stack" with the layers of one picture. */
  function fill(stack, scene, method, kind) {
    const images = scene.methods[method].layers[kind].map(([place, opacity]) => {
      const image = new Image();
      image.alt = "";
      image.draggable = false;
      image.style.opacity = opacity;
      image.src = lab.pictures[place];
      return image;
    });
    stack.style.aspectRatio = `${scene.width} / ${scene.height}`;
    stack.replaceChildren(...images, overlay(scene, kind === "difference" ? scene.methods[method].boxes : []));
  }

  /** A drawing in pixel units on top of a picture, with a frame around each cluster. */
  function overlay(scene, boxes) {
    const drawing = document.createElementNS(SVG, "svg");
    drawing.setAttribute("viewBox", `0 0 ${scene.width} ${scene.height}`);
    drawing.setAttribute("aria-hidden", "true");
    const margin = Math.max(scene.width, scene.height) / 64;
    for (const [row0, column0, row1, column1] of boxes) {
      drawing.append(frame("box", column0 - margin, row0 - margin, column1 - column0 + 2 * margin, row1 - row0 + 2 * margin));
    }
    return drawing;
  }

  function frame(name, x, y, width, height) {
    const rectangle = document.createElementNS(SVG, "rect");
    rectangle.setAttribute("class", name);
    for (const [key, value] of Object.entries({ x, y, width, height })) rectangle.setAttribute(key, value);
    return rectangle;
  }

  function fillThumb(button) {
    const { scene, method, kind } = button.dataset;
    fill(button.firstElementChild, lab.scenes[scene], Number(method), kind);
  }

  const thumbs = [...document.querySelectorAll(".thumb")];
  const seen = new IntersectionObserver((entries) => {
    for (const entry of entries.filter((entry) => entry.isIntersecting)) {
      seen.unobserve(entry.target);
      fillThumb(entry.target);
    }
  }, { rootMargin: "800px" });

  for (const button of thumbs) {
    const scene = lab.scenes[button.dataset.scene];
    const stack = document.createElement("div");
    stack.className = "stack";
    stack.style.aspectRatio = `${scene.width} / ${scene.height}`;
    button.append(stack);
    button.addEventListener("click", () => open(scene, Number(button.dataset.method), button.dataset.kind));
    seen.observe(button);
  }
  addEventListener("beforeprint", () => thumbs.forEach(fillThumb));

  // ---------------------------------------------------------------- viewer

  const dialog = document.getElementById("viewer");
  const panes = ["left", "right"].map((side) => {
    const element = document.getElementById(`pane-${side}`);
    const stack = document.createElement("div");
    stack.className = "stack";
    const stage = element.querySelector(".stage");
    stage.append(stack);
    const [method, kind] = element.querySelectorAll("select");
    return { stage, stack, choose: { method, kind }, method: 0, kind: "faces" };
  });
  const [left, right] = panes;
  let scene = lab.scenes[0];
  let place = { scale: 1, x: 0, y: 0 }; // of the picture's corner in each stage, in CSS pixels
  let cursor = { row: 0, column: 0 };
  let cluster = -1;

  function open(chosen, method, kind) {
    scene = chosen;
    cluster = -1;
    cursor = { row: scene.height >> 1, column: scene.width >> 1 };
    Object.assign(left, { method: scene.reference, kind });
    Object.assign(right, { method, kind });
    document.getElementById("viewer-title").textContent = scene.name;
    for (const pane of panes) {
      pane.choose.method.replaceChildren(...scene.methods.map(({ name }, k) => new Option(name, k)));
    }
    dialog.showModal();
    dialog.focus(); // else the first button would have it
    show();
    fit();
  }

  /** Show the chosen pictures. */
  function show() {
    for (const pane of panes) {
      const { layers } = scene.methods[pane.method];
      const kind = [pane.kind, "faces", "picture"].find((name) => name in layers); // the reference differs from nothing
      fill(pane.stack, scene, pane.method, kind);
      pane.stack.lastElementChild.append(frame("cursor", 0, 0, 1, 1), frame("cursor", 0, 0, 1, 1));
      pane.choose.method.value = pane.method;
      pane.choose.kind.replaceChildren(...Object.keys(layers).map((name) => new Option(name, name)));
      pane.choose.kind.value = kind;
    }
    move(cursor.row, cursor.column);
  }

  function transform() {
    for (const { stack } of panes) {
      stack.style.width = `${scene.width * place.scale}px`; // not scale(): lines keep their width
      stack.style.transform = `translate(${place.x}px, ${place.y}px)`;
    }
  }

  /** Put a point of the picture into the middle of the stages. */
  function centre(row, column, scale) {
    const { width, height } = left.stage.getBoundingClientRect();
    place = { scale, x: width / 2 - column * scale, y: height / 2 - row * scale };
    transform();
  }

  function fit() {
    const { width, height } = left.stage.getBoundingClientRect();
    centre(scene.height / 2, scene.width / 2, Math.min(width / scene.width, height / scene.height));
  }

  /** Zoom about a point of the stage, which stays where it is. */
  function zoom(factor, x, y) {
    const scale = Math.min(Math.max(place.scale * factor, 1 / 8), MAX_SCALE);
    const ratio = scale / place.scale;
    place = { scale, x: x - (x - place.x) * ratio, y: y - (y - place.y) * ratio };
    transform();
  }

  function zoomAtCursor(factor) {
    zoom(factor, place.x + (cursor.column + 0.5) * place.scale, place.y + (cursor.row + 0.5) * place.scale);
  }

  /** Move the cursor, in both panes, to a pixel. */
  function move(row, column) {
    cursor = {
      row: Math.min(Math.max(row, 0), scene.height - 1),
      column: Math.min(Math.max(column, 0), scene.width - 1),
    };
    for (const rectangle of dialog.querySelectorAll(".cursor")) {
      rectangle.setAttribute("x", cursor.column);
      rectangle.setAttribute("y", cursor.row);
    }
    document.getElementById("viewer-position").textContent = `row ${cursor.row}, column ${cursor.column}`;
  }

  /** Go to the next or previous large cluster of the method on the right. */
  function nextCluster(step) {
    const boxes = scene.methods[right.method].boxes;
    if (!boxes.length) return;
    cluster = (Math.max(cluster, step > 0 ? -1 : 0) + step + boxes.length) % boxes.length;
    const [row0, column0, row1, column1] = boxes[cluster];
    const { width, height } = left.stage.getBoundingClientRect();
    const scale = Math.min(width / (column1 - column0), height / (row1 - row0)) / 3;
    centre((row0 + row1) / 2, (column0 + column1) / 2, Math.min(Math.max(scale, 1), MAX_SCALE / 2));
    move((row0 + row1) >> 1, (column0 + column1) >> 1);
  }

  function swap() {
    [left.method, right.method] = [right.method, left.method];
    [left.kind, right.kind] = [right.kind, left.kind];
    show();
  }

  // ---------------------------------------------------------------- hands

  for (const pane of panes) {
    const { stage } = pane;
    for (const [what, select] of Object.entries(pane.choose)) {
      select.addEventListener("change", () => {
        pane[what] = what === "method" ? Number(select.value) : select.value;
        cluster = -1;
        show();
      });
    }
    stage.addEventListener("wheel", (event) => {
      event.preventDefault();
      const { left: x, top: y } = stage.getBoundingClientRect();
      zoom(Math.exp(-event.deltaY / 400), event.clientX - x, event.clientY - y);
    }, { passive: false });
    stage.addEventListener("pointerdown", (event) => stage.setPointerCapture(event.pointerId));
    stage.addEventListener("pointermove", (event) => {
      if (event.buttons) {
        place = { ...place, x: place.x + event.movementX, y: place.y + event.movementY };
        transform();
        return;
      }
      const { left: x, top: y } = stage.getBoundingClientRect();
      move(Math.floor((event.clientY - y - place.y) / place.scale), Math.floor((event.clientX - x - place.x) / place.scale));
    });
  }
  addEventListener("resize", () => dialog.open && fit());

  const actions = {
    "+": () => zoomAtCursor(1.5),
    "=": () => zoomAtCursor(1.5),
    "-": () => zoomAtCursor(1 / 1.5),
    0: () => centre(cursor.row, cursor.column, 1),
    f: fit,
    b: swap,
    "]": () => nextCluster(1),
    "[": () => nextCluster(-1),
    Escape: () => dialog.close(),
  };
  for (const [kind, key] of Object.entries(KINDS)) {
    actions[key] = () => {
      for (const pane of panes) pane.kind = kind;
      show();
    };
  }
  const arrows = { ArrowUp: [-1, 0], ArrowDown: [1, 0], ArrowLeft: [0, -1], ArrowRight: [0, 1] };

  dialog.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || event.target.tagName === "SELECT") return;
    const digit = /^Digit([1-9])$/.exec(event.code);
    if (digit) {
      const method = Number(digit[1]) - 1;
      if (method >= scene.methods.length) return;
      (event.shiftKey ? left : right).method = method;
      cluster = -1;
      show();
    } else if (event.key in arrows) {
      const stride = event.shiftKey ? 10 : 1;
      const [down, across] = arrows[event.key];
      move(cursor.row + stride * down, cursor.column + stride * across);
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

  /** Open what the address names: #check=KEY&x=COLUMN&y=ROW. */
  function follow() {
    const named = new URLSearchParams(location.hash.slice(1));
    const found = lab.scenes.find(({ key }) => key !== undefined && key === named.get("check"));
    if (!found) return;
    open(found, found.methods.length - 1, "difference");
    if (!named.has("x")) return;
    centre(Number(named.get("y")) + 0.5, Number(named.get("x")) + 0.5, MAX_SCALE / 4);
    move(Number(named.get("y")), Number(named.get("x")));
  }
  addEventListener("hashchange", follow);
  follow();
})();
