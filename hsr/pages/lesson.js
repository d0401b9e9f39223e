"use strict";
(async () => {
  const SVG = "http://www.w3.org/2000/svg";
  const CELL = 40;
  const $ = (id) => document.getElementById(id);

  // ---------------------------------------------------------------- the recording

  const packed = Uint8Array.from(atob($("recording").textContent), (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  const lesson = await new Response(stream).json();

  const state = { screen: 0, track: 0, at: 0, playing: false, asking: null, right: 0, answered: 0 };
  const done = new Set();
  let panels = [];

  // ---------------------------------------------------------------- drawing

  function element(name, attributes, ...children) {
    const made = name.startsWith("svg:") ? document.createElementNS(SVG, name.slice(4)) : document.createElement(name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    made.append(...children);
    return made;
  }

  /** A buffer as a grid of cells; a click goes to the next turn of the sample. */
  class Grid {
    constructor(track, label, longest, ties) {
      this.width = track.width;
      this.label = label;
      this.cells = Array.from({ length: track.width * track.height }, (_, sample) => {
        const x = (sample % track.width) * CELL, y = Math.floor(sample / track.width) * CELL;
        const cell = element("svg:g", { class: "empty" },
          element("svg:rect", { x, y, width: CELL, height: CELL }),
          element("svg:text", { x: x + CELL / 2, y: y + CELL / 2 + 1, "font-size": Math.min(20, 1.55 * CELL / longest) }));
        if (ties.includes(sample)) cell.append(element("svg:circle", { class: "tie", cx: x + 33, cy: y + 7, r: 3.5 }));
        cell.addEventListener("click", () => toSample(sample));
        return cell;
      });
      this.cursor = element("svg:rect", { class: "cursor", width: CELL, height: CELL, visibility: "hidden" });
      this.svg = element("svg:svg", { class: "grid", role: "img", viewBox: `-3 -3 ${track.width * CELL + 6} ${track.height * CELL + 6}` }, ...this.cells, this.cursor);
      this.fresh = [];
    }

    set(sample, text, colour, empty) {
      const cell = this.cells[sample];
      cell.classList.toggle("empty", empty);
      cell.children[0].style.fill = colour;
      cell.children[1].textContent = text;
      cell.children[1].style.fontSize = text === "∞" ? "17px" : "";
    }

    mark(sample, fresh) {
      for (const old of this.fresh) this.cells[old].classList.remove("new");
      for (const now of fresh) this.cells[now].classList.add("new");
      this.fresh = fresh;
      this.cursor.setAttribute("visibility", sample < 0 ? "hidden" : "visible");
      this.cursor.setAttribute("x", (sample % this.width) * CELL);
      this.cursor.setAttribute("y", Math.floor(sample / this.width) * CELL);
      const where = sample < 0 ? "" : `; at column ${sample % this.width}, row ${Math.floor(sample / this.width)}: ${this.cells[sample].children[1].textContent || "nothing"}`;
      this.svg.setAttribute("aria-label", this.label + where);
    }
  }

  // ---------------------------------------------------------------- one method at work

  /** The state of one recording after its first `ran` steps. */
  class Panel {
    constructor(track, data) {
      this.track = track;
      this.data = data;
      const depths = data.writes.flatMap((list) => list.filter((_, k) => k % 3 === 2));
      const finite = depths.map(Number).filter(Number.isFinite);
      this.nearest = Math.min(...finite);
      this.extent = Math.max(...finite) - this.nearest || 1;
      this.faces = new Grid(track, "face buffer", 2, track.ties);
      this.depths = new Grid(track, "depth buffer", Math.max(3, ...depths.map((text) => text.length)), []);
      this.counters = Object.entries(data.counters).map(([name, line]) => ({ name, line, shown: element("b", {}) }));
      this.element = element("div", { class: "panel" },
        element("h3", {}, `${data.method} `, element("span", {}, data.about)),
        this.figure("face buffer", this.faces), this.figure("depth buffer", this.depths),
        element("p", { class: "counters" }, ...this.counters.map((counter) => element("span", {}, `${counter.name} `, counter.shown))));
      this.element.style.setProperty("--ratio", track.width / track.height);
      this.reset();
    }

    figure(name, grid) {
      return element("figure", {}, element("figcaption", {}, name), grid.svg);
    }

    reset() {
      this.ran = 0;
      this.values = [];
      this.before = [];
      this.changed = [];
      this.counts = new Map(this.counters.map((counter) => [counter.line, 0]));
      for (let sample = 0; sample < this.faces.cells.length; sample++) this.write(sample, -1, "∞");
    }

    write(sample, face, depth) {
      const known = this.track.faces[face];
      this.faces.set(sample, known ? known.letter : "", known ? known.colour : "", !known);
      const share = (Number(depth) - this.nearest) / this.extent;
      this.depths.set(sample, depth, `hsl(0 0% ${Math.round(94 - 40 * share)}%)`, !Number.isFinite(share) || !known);
    }

    seek(target) {
      if (target < this.ran) this.reset();
      while (this.ran < target) {
        const step = this.ran++;
        const line = this.data.lines[step], changes = this.data.changes[step], writes = this.data.writes[step];
        this.changed = [];
        for (let k = 0; k < changes.length; k += 2) {
          const slot = changes[k];
          this.before[slot] = this.values[slot];
          this.values[slot] = changes[k + 1];
          this.changed.push(slot);
        }
        for (let k = 0; k < writes.length; k += 3) this.write(writes[k], writes[k + 1], writes[k + 2]);
        if (this.counts.has(line)) this.counts.set(line, this.counts.get(line) + 1);
      }
    }

    /** How many turns have begun after some steps. */
    begun(steps) {
      let low = 0, high = this.data.turns.length;
      while (low < high) {
        const middle = (low + high) >> 1;
        if (this.data.turns[middle][0] < steps) low = middle + 1; else high = middle;
      }
      return low;
    }

    show(sample) {
      const turn = this.begun(this.ran);
      const fresh = this.ran ? this.data.writes[this.ran - 1].filter((_, k) => k % 3 === 0) : [];
      const now = sample ?? (turn ? this.data.turns[turn - 1][1] : -1);
      const few = fresh.length > 16 ? [] : fresh;
      this.faces.mark(now, few);
      this.depths.mark(now, few);
      for (const counter of this.counters) counter.shown.textContent = this.counts.get(counter.line).toLocaleString("en");
    }
  }

  // ---------------------------------------------------------------- positions

  // With one method a position is a number of steps; with two, a number of turns of both.
  const track = () => lesson.tracks[state.track];
  const paired = () => panels.length > 1;
  const last = () => paired() ? Math.max(...panels.map((panel) => panel.data.turns.length)) : panels[0].data.lines.length;

  function stepsAt(panel, position) {
    if (!paired()) return position;
    return position < panel.data.turns.length ? panel.data.turns[position][0] : panel.data.lines.length;
  }

  /** The questions of a track, each at the position just before its turn. */
  function questions() {
    return track().asked.map((asked, number) => ({
      ...asked,
      id: `${state.track}/${number}`,
      at: paired() ? panels[0].begun(asked.step) : asked.step,
    }));
  }

  /** The position after a question's turn. */
  function after(question) {
    const turn = panels[0].begun(question.step);
    if (paired()) return turn + 1;
    return turn + 1 < panels[0].data.turns.length ? panels[0].data.turns[turn + 1][0] : last();
  }

  function go(position) {
    state.at = Math.min(Math.max(Math.round(position), 0), last());
    for (const panel of panels) panel.seek(stepsAt(panel, state.at));
    const open = state.asking && state.asking.at === state.at;
    if (!open) ask(null);
    for (const panel of panels) panel.show(open && panel === panels[0] ? state.asking.sample : undefined);
    showLine();
    $("scrub").value = state.at;
    $("count").textContent = `${paired() ? "turn" : "step"} ${state.at.toLocaleString("en")} of ${last().toLocaleString("en")}`;
  }

  /** Go on, but not past a question that waits for its answer. */
  function forward(target) {
    const waiting = questions().find((question) => question.at >= state.at && question.at < target && !done.has(question.id));
    if (!waiting || (state.asking && waiting.id === state.asking.id)) return go(target);
    play(false);
    state.asking = waiting;
    go(waiting.at);
    askFace(waiting);
    $("ask").scrollIntoView({ block: "nearest" });
  }

  function nextTurn(way) {
    if (paired()) return way > 0 ? forward(state.at + 1) : go(state.at - 1);
    const turns = panels[0].data.turns;
    const wanted = panels[0].begun(state.at) - 1 + way;
    if (wanted < 0) return go(0);
    const target = wanted < turns.length ? turns[wanted][0] + 1 : last();
    return way > 0 ? forward(target) : go(target);
  }

  /** Go to the next turn of a sample, after the last one to the first again. */
  function toSample(sample) {
    play(false);
    const turns = panels[0].data.turns.map(([step, of], turn) => (of === sample ? (paired() ? turn : step) + 1 : -1));
    const target = turns.find((position) => position > state.at) ?? turns.find((position) => position >= 0);
    if (target === undefined) $("formula").textContent = "no step is busy with this sample";
    else go(target);
  }

  // ---------------------------------------------------------------- the listing

  function showLine() {
    if (paired()) return;
    const panel = panels[0], data = panel.data;
    const line = panel.ran ? data.lines[panel.ran - 1] : -1;
    for (const item of $("lines").querySelectorAll("[aria-current]")) item.removeAttribute("aria-current");
    const current = $("lines").children[line];
    if (current) {
      current.setAttribute("aria-current", "true");
      const room = $("lines").clientHeight, top = current.offsetTop - $("lines").scrollTop;
      if (top < room * .15 || top > room * .8) $("lines").scrollTop = current.offsetTop - room * .4;
    }
    const own = data.slots.map(([name], slot) => [name, slot]).filter(([name, slot]) => name === data.functions[line] && panel.values[slot] !== undefined);
    $("values").replaceChildren(...own.map(([, slot]) => element("div", { class: panel.changed.includes(slot) ? "changed" : "" },
      element("dt", {}, data.slots[slot][1]), element("dd", {}, panel.values[slot]))));
    $("formula").textContent = filled(data.formulas[line] ?? "", panel, data.functions[line]);
  }

  /** A line of source that wraps under itself; two places an indent are enough here. */
  function sourceLine(text) {
    const line = text.trimStart();
    const item = element("li", { class: line.startsWith("#") ? "comment" : "" }, line);
    item.style.setProperty("--indent", `${(text.length - line.length) / 2}ch`);
    return item;
  }

  /** Put values into a formula: {name} after the step, {~name} before it. */
  function filled(text, panel, inside) {
    return text.replace(/\{(~?)([^}]+)\}/g, (_, old, name) => {
      const slot = panel.data.slots.findIndex(([of, known]) => of === inside && known === name);
      const value = old && panel.changed.includes(slot) ? panel.before[slot] : panel.values[slot];
      return value ?? "…";
    });
  }

  // ---------------------------------------------------------------- questions

  function ask(question) {
    state.asking = question;
    $("ask").hidden = question === null && !onQuestion();
  }

  function offer(text, choices, answer) {
    $("ask-text").textContent = text;
    $("verdict").textContent = "";
    $("choices").replaceChildren(...choices.map((choice, k) => {
      const button = element("button", { type: "button" }, element("b", {}, `${k + 1}`), ...choice.map((part) => element("span", {}, part)));
      button.addEventListener("click", () => answer(k));
      return button;
    }));
    $("ask").hidden = false;
    $("say").classList.toggle("asking", !onQuestion());
  }

  function reveal(chosen, right, why, id) {
    for (const button of $("choices").children) button.disabled = true;
    if (chosen !== right) $("choices").children[chosen].classList.add("wrong");
    $("choices").children[right].classList.add("right");
    $("verdict").textContent = why;
    $("ask").scrollIntoView({ block: "nearest" });
    done.add(id);
    state.answered += 1;
    state.right += chosen === right;
    showScore();
  }

  function showScore() {
    $("score").textContent = `score ${state.right} of ${state.answered}`;
  }

  function askFace(question) {
    const faces = question.faces;
    offer(lesson.prompt, faces.map((face) => [badge(face), track().faces[face].name]), (chosen) => {
      if (done.has(question.id)) return;
      const sample = panels[0].depths.cells[question.sample].children[1];
      const held = sample.textContent;
      state.asking = null;
      go(after(question));
      $("ask").hidden = false;
      panels.forEach((panel) => panel.show(panel === panels[0] ? question.sample : undefined));
      const depth = sample.textContent;
      const moved = held === depth ? `The depth buffer still holds ${depth}.` : `The depth buffer held ${held}; now it holds ${depth}.`;
      reveal(chosen, faces.indexOf(question.owner), `It belongs to ${track().faces[question.owner].name}. ${moved}`, question.id);
    });
  }

  const onQuestion = () => state.screen === lesson.screens.length;

  function askLast() {
    const { text, choices, answer, why } = lesson.question;
    offer(text, choices.map((choice) => [choice]), (chosen) => {
      if (!done.has("question")) reveal(chosen, answer, why, "question");
    });
  }

  // ---------------------------------------------------------------- screens and tracks

  function badge(face) {
    const { letter, colour } = track().faces[face];
    const made = element("i", {}, letter);
    made.style.background = colour;
    return element("span", { class: "legend" }, made);
  }

  function openTrack(number) {
    state.track = number;
    panels = track().panels.map((data) => new Panel(track(), data));
    $("legend").replaceChildren(...Object.entries(track().faces).map(([face, { name }]) => element("span", {}, ...badge(face).children, name)));
    if (track().ties.length) $("legend").append(element("span", {}, "○ more than one face is admissible here"));
    $("panels").replaceChildren(...panels.map((panel) => panel.element));
    document.querySelector("main").classList.toggle("two", paired());
    $("hide").hidden = paired();
    $("lines").replaceChildren(...panels[0].data.listing.map(sourceLine));
    $("scrub").max = last();
    $("track").value = number;
    for (const [name, most] of [["column", track().width - 1], ["row", track().height - 1]]) $("jump").elements[name].max = most;
  }

  function openScreen(number) {
    play(false);
    state.screen = Math.min(Math.max(number, 0), lesson.screens.length);
    state.asking = null;
    $("place").textContent = onQuestion() ? "the question" : `${state.screen + 1} of ${lesson.screens.length}`;
    document.querySelector("[data-key=PageUp]").disabled = state.screen === 0;
    document.querySelector("[data-key=PageDown]").disabled = onQuestion();
    if (onQuestion()) {
      $("screen-title").textContent = "What have you seen?";
      $("screen-text").textContent = $("screen-formula").textContent = "";
      go(last());
      if (!done.has("question")) askLast();
      $("ask").hidden = false;
      return;
    }
    const screen = lesson.screens[state.screen];
    $("screen-title").textContent = screen.title;
    $("screen-text").textContent = screen.text;
    $("screen-formula").textContent = screen.formula;
    $("ask").hidden = true;
    if (screen.track !== null && screen.track !== state.track) openTrack(screen.track);
    go(paired() ? state.at : screen.steps[state.track] + 1);
  }

  function changeTrack(number) {
    play(false);
    const share = state.at / last();
    openTrack(number);
    go(share * last());
  }

  // ---------------------------------------------------------------- player

  function play(on) {
    if (state.playing === on) return;
    state.playing = on;
    $("play").textContent = on ? "stop" : "play";
    $("play").setAttribute("aria-label", on ? "stop" : "play");
    if (!on) return;
    if (state.at === last()) go(0);
    let before = performance.now(), owed = 0;
    requestAnimationFrame(function tick(now) {
      if (!state.playing) return;
      owed += 2 ** $("speed").value * (now - before) / 1000;
      before = now;
      const whole = Math.floor(owed);
      owed -= whole;
      if (whole) forward(state.at + whole);
      if (state.at === last()) play(false);
      requestAnimationFrame(tick);
    });
  }

  const keys = {
    ArrowRight: () => { play(false); forward(state.at + 1); },
    ArrowLeft: () => { play(false); go(state.at - 1); },
    n: () => { play(false); nextTurn(1); },
    p: () => { play(false); nextTurn(-1); },
    " ": () => play(!state.playing),
    ArrowUp: () => { $("speed").stepUp(); },
    ArrowDown: () => { $("speed").stepDown(); },
    Home: () => { play(false); go(0); },
    End: () => { play(false); go(last()); },
    PageDown: () => openScreen(state.screen + 1),
    PageUp: () => openScreen(state.screen - 1),
    t: () => changeTrack((state.track + 1) % lesson.tracks.length),
    g: () => $("jump").elements.column.select(),
    l: () => {
      const wide = document.querySelector("main").classList.toggle("wide");
      $("hide").setAttribute("aria-pressed", wide);
    },
    "?": () => $("keys").showModal(),
  };

  addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || $("keys").open) return;
    const typing = event.target.matches("input[type=number], select");
    if (typing || (event.target.matches("button") && [" ", "Enter"].includes(event.key))) return;
    const choice = $("ask").hidden ? undefined : $("choices").children[Number(event.key) - 1];
    if (choice) choice.click();
    else if (keys[event.key]) keys[event.key]();
    else return;
    event.preventDefault();
  });
  for (const button of document.querySelectorAll("[data-key]")) button.addEventListener("click", () => keys[button.dataset.key]());
  $("scrub").addEventListener("input", () => { play(false); go(Number($("scrub").value)); });
  $("track").addEventListener("change", () => changeTrack(Number($("track").value)));
  $("jump").addEventListener("submit", (event) => {
    event.preventDefault();
    const { column, row } = event.target.elements;
    toSample(Number(row.value) * track().width + Number(column.value));
    document.activeElement.blur();
  });

  $("track").replaceChildren(...lesson.tracks.map(({ label }, value) => element("option", { value }, label)));
  $("track").parentElement.hidden = lesson.tracks.length < 2;
  showScore();
  openTrack(0);
  openScreen(0);
})();
