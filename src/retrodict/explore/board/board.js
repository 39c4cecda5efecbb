// The drawing board: a plan to scale in SVG, moved by pointer and by keys. It computes no scene: every
// act goes to the server, which answers with what is to be drawn.
const NS = "http://www.w3.org/2000/svg";
const RAD = Math.PI / 180;
const WHEELS = ["front_left", "front_right", "rear_left", "rear_right"];
const NEAR = 12; // pixels within which a click takes a surveyed point
const BEYOND = 400; // pixels around the sheet in which surveyed points are drawn too, for a pan to bring in
const SETTLED = 200; // ms without a zoom after which the photograph is scaled anew
const TOOLS = {
  select: ["V", "Select and move", "Click a thing; drag it, or move it with the arrow keys and turn it with Q and E."],
  "put:A:impact": ["1", "A at impact", "Click where A stood at the impact."],
  "put:B:impact": ["2", "B at impact", "Click where B stood at the impact."],
  "put:A:rest": ["3", "A at rest", "Click where A came to rest."],
  "put:B:rest": ["4", "B at rest", "Click where B came to rest."],
  point: ["P", "Impact point", "Click the impact point on the ground."],
  hit: ["H", "Place hit", "Click the place that was hit on an outline at the impact."],
  line: ["L", "Contact line", "Click two points along the contact line, or along the face of the wall."],
  mark: ["M", "Mark", "Click a point that the selected vehicle passed on its way to rest."],
  end: ["N", "End of rotation", "Click where the selected vehicle stopped sliding sideways."],
  edge: ["D", "Road edge", "Click two points along the edge; the other surface lies to the left of them."],
  area: ["O", "Area", "Click the corners of an area of other friction; Enter ends it."],
  corners: ["C", "Four corners", "Click front left, front right, rear right, rear left of the selected vehicle."],
  ruler: ["R", "Ruler", "Click two points to measure between them."],
  scale: ["S", "Scale", "Click two points of the photograph, then write how far apart they are."],
  north: ["U", "North", "Click two points of the photograph, the second north of the first."],
  origin: ["I", "Origin", "Click the point of the photograph that is to be x = 0, y = 0."],
};
const FIRST = ["select", "put:A:impact", "point", "mark", "ruler", "scale"]; // each begins a group of buttons
const CLICKS = { line: 2, edge: 2, ruler: 2, scale: 2, north: 2, corners: 4 };

function element(name, attributes, parent, text) {
  const made = document.createElementNS(NS, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  if (text !== undefined) made.textContent = text; // text is never markup
  if (parent) parent.appendChild(made);
  return made;
}

function turned([u, w], heading) {
  const c = Math.cos(heading * RAD), s = Math.sin(heading * RAD);
  return [c * u - s * w, s * u + c * w];
}

const plus = (a, b) => [a[0] + b[0], a[1] + b[1]];
const minus = (a, b) => [a[0] - b[0], a[1] - b[1]];
const norm = (a) => Math.hypot(a[0], a[1]);
const bearing = (a) => Math.atan2(a[1], a[0]) / RAD;
const wrap = (angle) => angle - 360 * Math.round(angle / 360);

export default {
  template: `
    <div class="plan-board">
      <div class="tools" role="toolbar" aria-label="tools"></div>
      <div class="sheet" tabindex="0" role="application" aria-label="drawing board">
        <img class="ground" alt="" draggable="false" hidden>
        <canvas class="survey" aria-hidden="true" hidden></canvas>
        <svg class="ink" xmlns="http://www.w3.org/2000/svg"></svg>
        <div class="ask" hidden><label></label><input type="text"><button type="button">Set</button></div>
      </div>
      <div class="hint" role="status" aria-live="polite"></div>
    </div>`,
  props: { first: Object, survey: Array, lines: Array, units: String },
  mounted() {
    this.d = this.first;
    this.points = this.survey || [];
    this.plan = this.lines || [];
    this.count = 0; // acts that were sent
    this.pending = []; // drags that were sent and are not answered: drawn, so that nothing jumps back
    this.foot = this.units === "us";
    this.tool = "select";
    this.sel = null; // {kind, letter, at, number}
    this.clicks = [];
    this.cursor = null; // place of the keyboard's crosshair, m
    this.fingers = new Map();
    this.sheet = this.$el.querySelector(".sheet");
    this.svg = this.$el.querySelector("svg");
    this.img = this.$el.querySelector("img");
    this.layer = this.$el.querySelector("canvas");
    this.hint = this.$el.querySelector(".hint");
    this.ask = this.$el.querySelector(".ask");
    this.world = element("g", { class: "world" }, this.svg);
    this.over = element("g", { class: "over" }, this.svg);
    this.buttons();
    this.listen();
    this.size();
    this.fit();
    new ResizeObserver(() => { this.size(); this.draw(); }).observe(this.sheet);
  },
  unmounted() { clearTimeout(this.settling); document.removeEventListener("keydown", this.shortcut); },
  methods: {
    // what the server calls
    show(drawing) {
      this.d = drawing;
      // a drag that has begun meanwhile goes on: the server may answer late
      this.pending = this.pending.filter((drag) => drag.sent > drawing.done);
      // what was placed a moment ago may not be in a late answer yet
      const settled = drawing.done >= this.count;
      if (settled && this.sel && this.sel.kind === "car" && !this.poseOf(this.sel)) this.sel = null;
      this.draw();
    },
    surveyed(points, lines) { this.points = points; this.plan = lines; this.draw(); },
    measure(units) { this.foot = units === "us"; this.draw(); },
    refuse(text) { this.say(text, true); },
    markPart(part) { this.part = part; },
    choose(letter, at) { this.sel = { kind: "car", letter, at }; this.draw(); },

    act(name, values) { this.$emit("act", { number: ++this.count, name, values }); },
    send(drag, name, values) { this.act(name, values); this.pending.push({ ...drag, sent: this.count }); },
    pick() {
      const s = this.sel;
      this.$emit("pick", s ? { thing: s.letter || (s.kind === "ground" ? "ground" : "impact") } : {});
    },
    say(text, bad) { this.hint.textContent = text; this.hint.classList.toggle("bad", !!bad); },

    // places on the sheet: pixels <-> metres
    size() {
      const box = this.sheet.getBoundingClientRect();
      this.w = Math.max(box.width, 50);
      this.h = Math.max(box.height, 50);
      this.svg.setAttribute("viewBox", `0 0 ${this.w} ${this.h}`);
    },
    px([x, y]) { return [this.ox + this.s * x, this.oy - this.s * y]; },
    m(px, py) { return [(px - this.ox) / this.s, (this.oy - py) / this.s]; },
    at(event) {
      const box = this.sheet.getBoundingClientRect();
      return [event.clientX - box.left, event.clientY - box.top];
    },
    fit() {
      const seen = [];
      for (const car of this.d.cars) {
        if (car.at) seen.push(...this.outline(car, car.at, car.heading));
        if (car.rest) seen.push(...this.outline(car, car.rest, car.restHeading || 0));
        for (const mark of car.marks) seen.push([mark[1], mark[2]]);
      }
      if (this.d.point) seen.push(this.d.point);
      for (const ground of this.d.grounds) seen.push(...ground.corners);
      if (!seen.length && this.d.backdrop) seen.push(...this.frame());
      for (const each of seen.length ? [] : this.points) seen.push([each[1], each[2]]);
      if (!seen.length) seen.push([-15, -10], [15, 10]);
      const xs = seen.map((p) => p[0]), ys = seen.map((p) => p[1]);
      const x0 = Math.min(...xs) - 2, x1 = Math.max(...xs) + 2, y0 = Math.min(...ys) - 2, y1 = Math.max(...ys) + 2;
      this.s = Math.min(this.w / (x1 - x0), this.h / (y1 - y0));
      this.ox = this.w / 2 - this.s * (x0 + x1) / 2;
      this.oy = this.h / 2 + this.s * (y0 + y1) / 2;
      this.draw();
    },
    frame() {
      const b = this.d.backdrop, w = b.width * b.metres, h = b.height * b.metres;
      return [[0, 0], [w, 0], [w, -h], [0, -h]].map((c) => plus([b.x, b.y], turned(c, b.turn)));
    },
    zoom(by, px = this.w / 2, py = this.h / 2) {
      const s = Math.min(Math.max(this.s * by, 0.5), 2000);
      this.ox = px - (px - this.ox) * s / this.s;
      this.oy = py - (py - this.oy) * s / this.s;
      this.s = s;
      this.moved();
    },
    pan(dx, dy) { this.ox += dx; this.oy += dy; this.moved(); },
    moved() { // once a frame, however many events arrive
      if (this.frameAsked) return;
      this.frameAsked = requestAnimationFrame(() => { this.frameAsked = 0; this.view(); });
    },
    snap(place) {
      let best = null, off = NEAR / this.s;
      for (const point of this.points) {
        const far = Math.hypot(point[1] - place[0], point[2] - place[1]);
        if (far < off) { off = far; best = [point[1], point[2]]; }
      }
      return best || place;
    },
    length(metres) {
      if (!this.foot) return `${metres.toFixed(2)} m`;
      const inches = metres / 0.0254, feet = Math.floor(inches / 12);
      return `${feet}' ${(inches - 12 * feet).toFixed(1)}"`;
    },

    // drawing
    outline(car, at, heading) {
      const a = car.length / 2, h = car.width / 2;
      return [[a, h], [a, -h], [-a, -h], [-a, h]].map((c) => plus(at, turned([c[0] + car.middle, c[1]], heading)));
    },
    spots(car) { // the wheels, from the centre of gravity
      const h = car.track / 2;
      return { front_left: [car.front, h], front_right: [car.front, -h], rear_left: [-car.rear, h], rear_right: [-car.rear, -h] };
    },
    poseOf(s) {
      const car = this.d.cars.find((each) => each.letter === s.letter);
      if (!car) return null;
      if (s.at === "rest") return car.rest ? { car, at: car.rest, heading: car.restHeading || 0 } : null;
      return car.at ? { car, at: car.at, heading: car.heading } : null;
    },
    now(car, at) { // the pose as it is being dragged
      const pose = this.poseOf({ letter: car.letter, at });
      for (const drag of pose ? this.drags("car") : []) {
        if (drag.letter !== car.letter || drag.at !== at) continue;
        pose.at = drag.place || pose.at;
        pose.heading += drag.by || 0;
      }
      return pose;
    },
    drags(kind) { return [...this.pending, ...(this.drag ? [this.drag] : [])].filter((drag) => drag.kind === kind); },
    placeNow(kind, place, letter, number) { // of the impact point or a mark
      const drag = this.drags(kind).filter((each) => each.place && each.letter === letter && each.number === number).pop();
      return drag ? drag.place : place;
    },
    ringNow(letter, sds) { // letter: of a vehicle at rest; none for the impact point
      const drag = this.drags("ring").filter((each) => each.sds && each.letter === letter).pop();
      return drag ? drag.sds : sds;
    },
    draw() { this.world.replaceChildren(); this.drawWorld(); this.view(); },
    polygon(points, attributes, parent = this.world) {
      return element("path", { d: `M${points.map((p) => `${p[0]} ${p[1]}`).join("L")}z`, ...attributes }, parent);
    },
    path(points, attributes) {
      return element("path", { d: `M${points.map((p) => `${p[0]} ${p[1]}`).join("L")}`, ...attributes }, this.world);
    },
    drawWorld() {
      const d = this.d;
      for (const ground of d.grounds) {
        const data = { "data-thing": JSON.stringify({ kind: "ground", name: ground.name }) };
        if (ground.corners.length) {
          element("title", {}, this.polygon(ground.corners, { class: "surface", ...data }), ground.name);
        } else {
          const far = turned([400, 0], ground.angle), side = ground.side === "left" ? 90 : -90;
          const deep = turned([400, 0], ground.angle + side);
          const a = minus(ground.point, far), b = plus(ground.point, far);
          element("title", {}, this.polygon([a, b, plus(b, deep), plus(a, deep)], { class: "surface", ...data }), ground.name);
        }
      }
      for (const line of this.plan) this.path(line, { class: "plan-line" });
      if (d.barrier && d.point && d.line !== null) {
        const away = this.away(), normal = turned([1, 0], d.line), sign = away;
        const n = [normal[0] * sign, normal[1] * sign], along = [-n[1], n[0]];
        if (d.barrier === "wall") {
          const reach = (k, deep) => [d.point[0] + k * along[0] + deep * n[0], d.point[1] + k * along[1] + deep * n[1]];
          this.polygon([reach(6, 0), reach(-6, 0), reach(-6, 0.6), reach(6, 0.6)], { class: "barrier" });
        } else {
          const r = d.diameter / 2;
          element("circle", { cx: d.point[0] + r * n[0], cy: d.point[1] + r * n[1], r, class: "barrier" }, this.world);
        }
      }
      for (const each of d.paths || []) this.path(each.points, { class: `way ${each.letter}` });
      for (const car of d.cars) {
        for (const at of ["rest", "impact"]) {
          const pose = this.now(car, at);
          if (!pose) continue;
          const thing = { kind: "car", letter: car.letter, at };
          const chosen = this.same(thing);
          const group = element("g", { class: `car ${car.letter} ${at}${chosen ? " chosen" : ""}${car.sized ? "" : " unsized"}` }, this.world);
          const body = this.outline(car, pose.at, pose.heading);
          element("title", {}, this.polygon(body, { class: "body", "data-thing": JSON.stringify(thing) }, group),
            `${car.name}, ${at === "rest" ? "at rest" : "at the impact"}`);
          const nose = car.middle + car.length / 2, h = car.width / 2;
          const tip = [[nose, 0], [nose - h, 0.5 * h], [nose - h, -0.5 * h]].map((c) => plus(pose.at, turned(c, pose.heading)));
          this.polygon(tip, { class: "front" }, group);
          if (at === (car.rest ? "rest" : "impact")) {
            for (const [wheel, spot] of Object.entries(this.spots(car))) {
              const state = car.wheels ? car.wheels[wheel] : "locked";
              const box = [[0.32, 0.1], [0.32, -0.1], [-0.32, -0.1], [-0.32, 0.1]].map((c) => plus(pose.at, turned(plus(spot, c), pose.heading)));
              const word = ["locked", "damaged"].includes(state) ? state : state.startsWith("rolling") ? "rolling" : "other";
              const made = this.polygon(box, { class: `wheel ${word}`, "data-thing": JSON.stringify({ ...thing, wheel }) }, group);
              element("title", {}, made, `${wheel.replace("_", " ")}: ${state}`);
            }
          }
        }
        if (car.rest && car.restSd) this.ring(this.now(car, "rest").at, this.ringNow(car.letter, car.restSd));
      }
      if (d.point && d.pointSd) this.ring(this.placeNow("point", d.point), this.ringNow(undefined, d.pointSd));
      for (const [kind, angle] of [["proposal", d.line === null ? d.proposal : null], ["line", this.lineNow()]]) {
        if (angle === null || !d.point) continue;
        const along = turned([2.2, 0], angle + 90);
        this.path([minus(d.point, along), plus(d.point, along)], { class: kind });
      }
    },
    ring(at, sds) { // two standard deviations
      element("ellipse", { cx: at[0], cy: at[1], rx: 2 * sds[0], ry: 2 * sds[1], class: "ring" }, this.world);
    },
    ringKnobs(at, sds, letter) {
      for (const axis of [0, 1]) {
        const [x0, y0] = this.px(at), far = Math.max(2 * sds[axis] * this.s, 18); // a small ring leaves room
        const [x, y] = axis ? [x0, y0 - far] : [x0 + far, y0];
        const made = element("rect", { x: x - 5, y: y - 5, width: 10, height: 10, class: "knob ring-knob", "data-thing": JSON.stringify({ kind: "ring", letter, axis }) }, this.over);
        element("title", {}, made, `uncertainty in ${"xy"[axis]}: ± ${this.length(sds[axis])}`);
      }
    },
    away() { // 1 where the contact line's normal points from A to the barrier
      const a = this.d.cars.find((each) => each.letter === "A");
      if (!a || !a.at) return 1;
      const n = turned([1, 0], this.d.line), to = minus(this.d.point, a.at);
      return n[0] * to[0] + n[1] * to[1] < 0 ? -1 : 1;
    },
    lineNow() {
      const drag = this.drags("line").pop();
      return drag ? drag.angle : this.d.line;
    },
    same(thing) {
      const s = this.sel;
      return !!s && s.kind === thing.kind && s.letter === thing.letter && s.at === thing.at && s.number === thing.number && s.name === thing.name;
    },
    view() { // what follows pan and zoom
      this.world.setAttribute("transform", `matrix(${this.s} 0 0 ${-this.s} ${this.ox} ${this.oy})`);
      this.photograph();
      this.movePoints();
      this.over.replaceChildren();
      this.grid();
      const d = this.d;
      for (const car of d.cars) {
        for (const at of ["impact", "rest"]) {
          const pose = this.now(car, at);
          if (!pose) continue;
          const [x, y] = this.px(pose.at);
          if (at === "impact" && this.warned(car.letter)) this.badge(x + 22, y - 14, car.letter);
        element("text", { x, y, class: `label ${car.letter}`, "text-anchor": "middle", "dominant-baseline": "central" }, this.over, car.letter);
          const thing = { kind: "car", letter: car.letter, at };
          if (!this.same(thing)) continue;
          const nose = this.px(plus(pose.at, turned([car.middle + car.length / 2, 0], pose.heading)));
          const reach = 34, unit = turned([1, 0], pose.heading);
          const knob = [nose[0] + reach * unit[0], nose[1] - reach * unit[1]];
          element("path", { d: `M${nose}L${knob}`, class: "arm" }, this.over);
          const made = element("circle", { cx: knob[0], cy: knob[1], r: 9, class: "knob turn", "data-thing": JSON.stringify({ ...thing, turn: true }) }, this.over);
          element("title", {}, made, "turn");
          if (at === "impact") this.courseHandle(car, pose);
          else if (car.restSd) this.ringKnobs(pose.at, this.ringNow(car.letter, car.restSd), car.letter);
        }
        for (const [number, x, y, of] of car.marks) {
          const thing = { kind: "mark", letter: car.letter, number };
          const [px, py] = this.px(this.placeNow("mark", [x, y], car.letter, number));
          const made = element("path", { d: `M${px - 6} ${py - 6}l12 12m0 -12l-12 12`, class: `mark ${car.letter}${this.same(thing) ? " chosen" : ""}`, "data-thing": JSON.stringify(thing) }, this.over);
          element("title", {}, made, `mark ${number + 1} of ${car.name}, ${of.replace("_", " ")}`);
        }
      }
      if (d.point) {
        const place = this.placeNow("point", d.point);
        const [x, y] = this.px(place);
        if (this.same({ kind: "point" }) && d.pointSd) this.ringKnobs(place, this.ringNow(undefined, d.pointSd));
        const made = element("circle", { cx: x, cy: y, r: 7, class: `knob impact${this.same({ kind: "point" }) ? " chosen" : ""}`, "data-thing": JSON.stringify({ kind: "point" }) }, this.over);
        element("title", {}, made, "impact point");
        if (this.warned("impact")) this.badge(x + 16, y - 14, "impact");
        const angle = this.lineNow();
        if (angle !== null) {
          const along = turned([1, 0], angle + 90), far = Math.max(2.2 * this.s, 40);
          for (const sign of [1, -1]) {
            const end = element("circle", { cx: x + sign * far * along[0], cy: y - sign * far * along[1], r: 8, class: "knob line", "data-thing": JSON.stringify({ kind: "line", sign }) }, this.over);
            element("title", {}, end, "turn the contact line");
          }
        }
      }
      this.drawClicks();
    },
    photograph() { // scaled once to what is seen of it, then moved as a whole
      const b = this.d.backdrop, img = this.img;
      img.hidden = !b;
      if (!b) return;
      const [x, y] = this.px([b.x, b.y]), wanted = this.s * b.metres;
      if (img.getAttribute("src") !== b.url) { img.src = b.url; this.scaled = 0; }
      clearTimeout(this.settling);
      if (!this.scaled) this.scaled = Math.min(wanted, 1);
      else if (this.scaled !== Math.min(wanted, 1)) this.settling = setTimeout(() => { this.scaled = 0; this.view(); }, SETTLED);
      img.style.width = `${b.width * this.scaled}px`;
      img.style.height = `${b.height * this.scaled}px`;
      img.style.transform = `translate(${x}px, ${y}px) rotate(${-b.turn}deg) scale(${wanted / this.scaled})`;
    },
    movePoints() { // the surveyed points, on a layer that a pan moves as a whole
      const canvas = this.layer, { points, s, w, h, ox, oy } = this;
      canvas.hidden = !points.length;
      if (canvas.hidden) return;
      const was = this.surveyedAt, same = was && was.points === points && was.s === s && was.w === w && was.h === h;
      if (!same || Math.abs(ox - was.ox) > BEYOND || Math.abs(oy - was.oy) > BEYOND) {
        this.surveyedAt = { points, s, w, h, ox, oy };
        this.drawPoints(canvas);
      }
      const { ox: x, oy: y } = this.surveyedAt;
      canvas.style.transform = `translate(${ox - x - BEYOND}px, ${oy - y - BEYOND}px)`;
    },
    drawPoints(canvas) {
      const fine = window.devicePixelRatio || 1, wide = this.w + 2 * BEYOND, high = this.h + 2 * BEYOND;
      canvas.width = wide * fine;
      canvas.height = high * fine;
      canvas.style.width = `${wide}px`;
      canvas.style.height = `${high}px`;
      const dot = document.createElement("canvas"), r = 2.5 * fine;
      dot.width = dot.height = Math.ceil(2 * r + 2);
      const ink = dot.getContext("2d"), pen = canvas.getContext("2d");
      ink.fillStyle = "#7a3ea8";
      ink.arc(dot.width / 2, dot.width / 2, r, 0, 2 * Math.PI);
      ink.fill();
      for (const [, x, y] of this.points) {
        const px = this.ox + this.s * x + BEYOND, py = this.oy - this.s * y + BEYOND;
        if (px < 0 || py < 0 || px > wide || py > high) continue;
        pen.drawImage(dot, Math.round(px * fine - dot.width / 2), Math.round(py * fine - dot.width / 2));
      }
    },
    warned(thing) { return (this.d.warnings || []).filter((each) => each.thing === thing).map((each) => each.words).join("\n"); },
    badge(x, y, thing) {
      const group = element("g", { class: "badge" }, this.over);
      element("path", { d: `M${x} ${y - 10}l10 18h-20z` }, group);
      element("text", { x, y: y + 6, "text-anchor": "middle" }, group, "!");
      element("title", {}, group, this.warned(thing));
    },
    courseHandle(car, pose) {
      const drag = this.drags("course").filter((each) => each.letter === car.letter && each.angle !== null).pop();
      const course = drag ? drag.angle : car.course === null ? pose.heading : car.course;
      const back = turned([1, 0], course + 180);
      const far = (car.length / 2 + Math.abs(car.middle)) * this.s + 44, [x, y] = this.px(pose.at);
      const tail = [x + far * back[0], y - far * back[1]], mid = [x + (far - 40) * back[0], y - (far - 40) * back[1]];
      element("path", { d: `M${tail}L${mid}`, class: `course ${car.letter}` }, this.over);
      const made = element("rect", { x: tail[0] - 7, y: tail[1] - 7, width: 14, height: 14, class: "knob", "data-thing": JSON.stringify({ kind: "course", letter: car.letter }) }, this.over);
      element("title", {}, made, "direction of travel before the impact");
    },
    grid() {
      const unit = this.foot ? 0.3048 : 1;
      const steps = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500];
      const step = unit * (steps.find((each) => each * unit * this.s >= 45) || 500);
      const [x0, y1] = this.m(0, 0), [x1, y0] = this.m(this.w, this.h);
      let said = "";
      for (let i = Math.ceil(x0 / step); i * step < x1; i++) {
        const x = this.px([i * step, 0])[0];
        said += `M${x} 0V${this.h}`;
        element("text", { x: x + 2, y: this.h - 4, class: "tick" }, this.over, `${+(i * step / unit).toFixed(1)}`);
      }
      for (let i = Math.ceil(y0 / step); i * step < y1; i++) {
        const y = this.px([0, i * step])[1];
        said += `M0 ${y}H${this.w}`;
        if (y > 14 && y < this.h - 16) element("text", { x: 3, y: y - 2, class: "tick" }, this.over, `${+(i * step / unit).toFixed(1)}`);
      }
      this.over.insertBefore(element("path", { d: said, class: "grid" }), this.over.firstChild);
      element("text", { x: this.w - 6, y: 16, class: "tick", "text-anchor": "end" }, this.over, this.foot ? "grid in feet" : "grid in metres");
    },
    drawClicks() {
      const marks = [...this.clicks];
      if (this.cursor && this.tool !== "select") {
        const [x, y] = this.px(this.cursor);
        element("path", { d: `M${x - 14} ${y}h28M${x} ${y - 14}v28`, class: "cross" }, this.over);
        marks.push(this.cursor);
      }
      if (marks.length > 1) element("path", { d: `M${marks.map((p) => this.px(p)).join("L")}`, class: "drawn" }, this.over);
      for (const place of this.clicks) {
        const [x, y] = this.px(place);
        element("circle", { cx: x, cy: y, r: 4, class: "drawn" }, this.over);
      }
      if (this.tool === "ruler" && marks.length > 1) {
        const [a, b] = marks.slice(-2), [x, y] = this.px([(a[0] + b[0]) / 2, (a[1] + b[1]) / 2]);
        element("text", { x, y: y - 8, class: "label", "text-anchor": "middle" }, this.over,
          `${this.length(norm(minus(b, a)))}, ${bearing(minus(b, a)).toFixed(1)}°`);
      }
    },

    // tools
    buttons() {
      const bar = this.$el.querySelector(".tools");
      let group;
      const begin = () => { group = bar.appendChild(document.createElement("div")); };
      for (const [name, [key, label, help]] of Object.entries(TOOLS)) {
        if (FIRST.includes(name)) begin();
        const made = document.createElement("button");
        made.type = "button";
        made.dataset.tool = name;
        made.title = `${help} (${key})`;
        made.textContent = label;
        made.addEventListener("click", () => { this.use(name); this.sheet.focus({ preventScroll: true }); });
        group.appendChild(made);
      }
      begin();
      for (const [label, help, what] of [["−", "Zoom out (-)", () => this.zoom(1 / 1.3)], ["+", "Zoom in (+)", () => this.zoom(1.3)], ["Fit", "Show everything (0)", () => this.fit()]]) {
        const made = document.createElement("button");
        made.type = "button";
        made.title = help;
        made.textContent = label;
        made.className = "view";
        made.addEventListener("click", what);
        group.appendChild(made);
      }
      this.use("select");
    },
    use(name) {
      this.tool = name;
      this.clicks = [];
      this.ask.hidden = true;
      for (const each of this.$el.querySelectorAll("[data-tool]")) each.setAttribute("aria-pressed", each.dataset.tool === name);
      this.sheet.classList.toggle("aims", name !== "select");
      this.say(TOOLS[name][2]);
      if (this.s) this.view();
    },
    letter() { // the vehicle that a tool is about
      if (this.sel && this.sel.letter) return this.sel.letter;
      return "A";
    },
    click(place) {
      const tool = this.tool;
      place = this.snap(place);
      const [x, y] = place;
      if (tool.startsWith("put:")) {
        const [, vehicle, at] = tool.split(":");
        const car = this.d.cars.find((each) => each.letter === vehicle);
        const heading = car && car.heading !== null ? car.heading : vehicle === "B" ? 180 : 0;
        this.sel = { kind: "car", letter: vehicle, at };
        this.act("place", { vehicle, at, x, y, heading });
        this.use("select");
        this.pick();
      } else if (tool === "point") {
        this.act("point", { x, y });
        this.use("select");
      } else if (tool === "hit") {
        let best = null;
        for (const car of this.d.cars) {
          if (!car.at) continue;
          const own = turned(minus(place, car.at), -car.heading);
          const a = car.length / 2, h = car.width / 2, u = own[0] - car.middle, w = own[1];
          if (Math.abs(u) > a + 0.5 || Math.abs(w) > h + 0.5) continue;
          const off = Math.min(Math.abs(a - Math.abs(u)), Math.abs(h - Math.abs(w)));
          // of two outlines that lie on each other, the one that is selected, then the nearer edge
          const order = this.sel && this.sel.letter === car.letter ? -1 : off;
          if (!best || order < best.order) best = { car, own, order };
        }
        if (!best) { this.say("Click on the outline of a vehicle at the impact.", true); return; }
        this.act("struck", { vehicle: best.car.letter, ahead: best.own[0], left: best.own[1] });
        this.use("select");
      } else if (tool === "mark" || tool === "end") {
        if (tool === "mark") this.act("mark", { vehicle: this.letter(), x, y, of: this.part || "centre" });
        else { this.act("end_of_rotation", { vehicle: this.letter(), x, y }); this.use("select"); }
      } else if (tool === "origin") {
        this.act("origin", { x, y });
        this.use("select");
      } else {
        if (CLICKS[tool] && this.clicks.length >= CLICKS[tool]) this.clicks = [];
        this.clicks.push(place);
        if (this.clicks.length === CLICKS[tool]) this.finish();
        this.view();
      }
    },
    finish() {
      const tool = this.tool, [a, b] = this.clicks;
      if (tool === "ruler") return;
      if (tool === "scale") {
        this.request("Distance between the two points", (text) => this.act("scale", { x1: a[0], y1: a[1], x2: b[0], y2: b[1], distance: text }));
        return;
      }
      if (tool === "line") this.act("line", { angle: bearing(minus(b, a)) - 90 });
      if (tool === "edge") this.act("edge", { stem: "verge", kind: "wet grass", x: a[0], y: a[1], angle: bearing(minus(b, a)), side: "left" });
      if (tool === "north") this.act("north", { x1: a[0], y1: a[1], x2: b[0], y2: b[1] });
      if (tool === "area" && this.clicks.length > 2) this.act("outline", { stem: "area", kind: "gravel", corners: this.clicks });
      if (tool === "corners") {
        const s = this.sel && this.sel.kind === "car" ? this.sel : { letter: "A", at: "rest" };
        this.act("corners", { vehicle: s.letter, at: s.at, corners: this.clicks });
      }
      this.use("select");
    },
    request(label, then) {
      const input = this.ask.querySelector("input"), button = this.ask.querySelector("button");
      this.ask.querySelector("label").textContent = label;
      this.ask.hidden = false;
      input.value = "";
      input.setAttribute("aria-label", label);
      input.placeholder = this.foot ? "like 32' 6\"" : "like 12.5 m";
      const done = () => { if (input.value.trim()) { then(input.value); this.use("select"); this.sheet.focus(); } };
      button.onclick = done;
      input.onkeydown = (event) => {
        event.stopPropagation();
        if (event.key === "Enter") done();
        if (event.key === "Escape") { this.use("select"); this.sheet.focus(); }
      };
      input.focus();
    },

    // pointer
    listen() {
      const on = (name, what) => this.svg.addEventListener(name, what);
      on("pointerdown", (event) => this.down(event));
      on("pointermove", (event) => this.move(event));
      on("pointerup", (event) => this.up(event));
      on("pointercancel", (event) => this.up(event, true));
      on("lostpointercapture", (event) => this.up(event, true)); // where neither came
      this.sheet.addEventListener("wheel", (event) => {
        event.preventDefault();
        this.zoom(Math.exp(-event.deltaY * 0.0015), ...this.at(event));
      }, { passive: false });
      this.sheet.addEventListener("keydown", (event) => this.key(event));
      this.shortcut = (event) => {
        if (!(event.ctrlKey || event.metaKey) || event.altKey) return;
        const key = event.key.toLowerCase(), typing = /^(input|textarea)$/i.test(event.target.tagName || "");
        const name = key === "s" ? "save" : typing ? "" : key === "y" || (key === "z" && event.shiftKey) ? "redo" : key === "z" ? "undo" : "";
        if (!name) return;
        event.preventDefault();
        if (typing) { event.target.blur(); event.target.focus(); } // what is being typed is sent, and saved too
        this.act(name, {});
      };
      document.addEventListener("keydown", this.shortcut);
    },
    down(event) {
      if (event.button > 1) return;
      this.sheet.focus({ preventScroll: true });
      try { this.svg.setPointerCapture(event.pointerId); } catch { /* it has been lifted already */ }
      const px = this.at(event);
      this.fingers.set(event.pointerId, px);
      this.start = { px, place: this.m(...px), moved: false, last: px };
      if (this.fingers.size > 1) { this.drag = null; return; }
      const said = event.target.dataset && event.target.dataset.thing;
      this.drag = null;
      if (this.tool !== "select" || event.button === 1) return;
      const thing = said ? JSON.parse(said) : null;
      this.start.thing = thing;
      if (!thing) return;
      if (thing.kind === "car") {
        const pose = this.now(this.d.cars.find((each) => each.letter === thing.letter), thing.at);
        this.drag = { kind: "car", letter: thing.letter, at: thing.at, wheel: thing.wheel, turn: thing.turn, from: pose.at, by: 0, last: null, pose };
        const chosen = { kind: "car", letter: thing.letter, at: thing.at };
        this.was = this.same(chosen);
        this.sel = chosen;
      } else if (thing.kind === "line" || thing.kind === "course") {
        this.drag = { kind: thing.kind, letter: thing.letter, angle: thing.kind === "line" ? this.d.line : null, sign: thing.sign };
      } else if (thing.kind === "ring") {
        const car = this.d.cars.find((each) => each.letter === thing.letter);
        this.drag = { ...thing, before: this.ringNow(thing.letter, car ? car.restSd : this.d.pointSd) };
      } else if (thing.kind !== "ground") {
        this.sel = thing;
        this.drag = { ...thing };
      } else {
        this.sel = thing;
      }
      this.draw();
    },
    move(event) {
      if (!this.fingers.has(event.pointerId)) {
        if (this.tool !== "select") { this.cursor = this.snap(this.m(...this.at(event))); this.moved(); }
        return;
      }
      const px = this.at(event), before = this.fingers.get(event.pointerId);
      if (this.fingers.size === 2) { // pinch
        const other = [...this.fingers].find(([id]) => id !== event.pointerId)[1];
        const by = norm(minus(px, other)) / Math.max(norm(minus(before, other)), 1);
        this.fingers.set(event.pointerId, px);
        this.start.moved = true;
        this.zoom(by, (px[0] + other[0]) / 2, (px[1] + other[1]) / 2);
        return;
      }
      this.fingers.set(event.pointerId, px);
      const start = this.start;
      if (!start.moved && norm(minus(px, start.px)) < 4) return;
      start.moved = true;
      const drag = this.drag, place = this.m(...px);
      if (!drag) { this.pan(px[0] - before[0], px[1] - before[1]); return; }
      if (drag.kind === "car" && drag.turn) {
        const angle = bearing(minus(place, drag.pose.at));
        const turn = wrap(angle - (drag.last === null ? bearing(minus(start.place, drag.pose.at)) : drag.last));
        drag.last = angle;
        drag.free = (drag.free || 0) + turn; // whole turns count
        drag.by = event.ctrlKey ? Math.round((drag.pose.heading + drag.free) / 5) * 5 - drag.pose.heading : drag.free;
        this.say(`${drag.letter} turned by ${drag.by.toFixed(1)}°`);
      } else if (drag.kind === "car") {
        drag.place = plus(drag.from, minus(place, start.place));
        this.say(`${drag.letter}: x ${this.length(drag.place[0])}, y ${this.length(drag.place[1])}`);
      } else if (drag.kind === "line") {
        drag.angle = bearing(minus(place, this.d.point)) - 90 + (drag.sign < 0 ? 180 : 0);
        this.say(`contact line ${wrap(drag.angle).toFixed(1)}° from the y axis`);
      } else if (drag.kind === "course") {
        const pose = this.poseOf({ letter: drag.letter, at: "impact" });
        drag.angle = bearing(minus(pose.at, place));
        this.say(`${drag.letter} travelled along ${drag.angle.toFixed(1)}°`);
      } else if (drag.kind === "ring") {
        const sd = Math.max(drag.before[drag.axis] + (place[drag.axis] - start.place[drag.axis]) / 2, 0.01);
        drag.sds = [...drag.before];
        drag.sds[drag.axis] = sd;
        if (event.shiftKey) drag.sds = [sd, sd];
        this.say(`± ${this.length(drag.sds[0])} in x, ± ${this.length(drag.sds[1])} in y`);
      } else {
        drag.place = this.snap(place);
        drag.along = event.shiftKey;
      }
      this.world.replaceChildren();
      this.drawWorld();
      this.moved();
    },
    up(event, cancelled) {
      if (!this.fingers.delete(event.pointerId)) return;
      const drag = this.drag, start = this.start;
      if (cancelled || this.fingers.size) { this.drag = null; this.draw(); return; }
      if (!start.moved) {
        this.drag = null;
        if (this.tool !== "select") { this.click(start.place); return; }
        if (drag && drag.wheel && this.was) this.act("wheel", { vehicle: drag.letter, wheel: drag.wheel });
        if (!start.thing) this.sel = null;
        this.draw();
        this.pick();
        return;
      }
      if (!drag) return;
      this.drag = null;
      const { kind, letter, place: to } = drag;
      if (kind === "car" && drag.turn) this.send(drag, "turn", { vehicle: letter, at: drag.at, by: drag.by });
      else if (kind === "car") this.send(drag, "place", { vehicle: letter, at: drag.at, x: to[0], y: to[1] });
      else if (kind === "line") this.send(drag, "line", { angle: wrap(drag.angle) });
      else if (kind === "course" && drag.angle !== null) this.send(drag, "course", { vehicle: letter, angle: drag.angle });
      else if (kind === "point") this.send(drag, "point", { x: to[0], y: to[1], along: !!drag.along });
      else if (kind === "mark") this.send(drag, "move_mark", { vehicle: letter, number: drag.number, x: to[0], y: to[1] });
      else if (kind === "ring") this.send(drag, "spread", { ...this.ofRing(letter), x: drag.sds[0], y: drag.sds[1] });
      this.draw();
    },

    ofRing(letter) { return letter ? { thing: "car", vehicle: letter } : { thing: "point" }; },

    // keys: everything that the pointer does
    key(event) {
      if (event.target !== this.sheet) return;
      const key = event.key, arrow = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[key];
      const fine = event.altKey ? 0.01 : event.shiftKey ? 1 : 0.1;
      if (event.ctrlKey || event.metaKey) return; // undo, redo and save belong to the page
      let used = true;
      const s = this.sel;
      if (arrow && this.tool !== "select") {
        this.cursor = plus(this.cursor || this.m(this.w / 2, this.h / 2), [arrow[0] * fine * 5, arrow[1] * fine * 5]);
        this.view();
      } else if (arrow && s && ["car", "point", "mark"].includes(s.kind)) {
        // by steps, so that none is lost while the server answers
        this.act("nudge", { thing: s.kind, vehicle: s.letter, at: s.at, number: s.number, dx: fine * arrow[0], dy: fine * arrow[1], along: event.shiftKey });
      } else if (arrow) {
        this.pan(-40 * arrow[0], 40 * arrow[1]);
      } else if (/^[qe]$/i.test(key)) {
        const by = (key.toLowerCase() === "q" ? 1 : -1) * (event.altKey ? 0.1 : event.shiftKey ? 15 : 1);
        if (s && s.kind === "car") this.act("turn", { vehicle: s.letter, at: s.at, by });
        else if (s && s.kind === "point") this.act("line", { by });
      } else if ((key === "[" || key === "]") && s && (s.kind === "point" || s.at === "rest")) {
        this.act("spread", { ...this.ofRing(s.letter), by: key === "]" ? 1.1 : 1 / 1.1 });
      } else if (key === "Enter" && this.tool === "area" && this.clicks.length > 2) {
        this.finish();
      } else if (key === "Enter" && this.tool !== "select") {
        this.click(this.cursor || this.m(this.w / 2, this.h / 2));
      } else if (key === "Escape") {
        this.drag = null;
        if (this.tool === "select") this.sel = null;
        this.use("select");
        this.draw();
      } else if (key === "Delete" || key === "Backspace") {
        if (s && s.kind === "mark") this.act("remove_mark", { vehicle: s.letter, number: s.number });
        else if (s && s.kind === "car" && s.at === "rest") this.act("write", { key: `vehicles.${s.letter}.rest`, value: "" });
        else if (s && s.kind === "ground") this.act("write", { key: `surfaces.${s.name}`, value: "" });
        this.sel = null;
      } else if (key === "." || key === ",") {
        this.next(key === "." ? 1 : -1);
      } else if (key === "+" || key === "=") this.zoom(1.3);
      else if (key === "-") this.zoom(1 / 1.3);
      else if (key === "0") this.fit();
      else if (/^[w]$/i.test(key) && s && s.kind === "car") {
        this.wheel = ((this.wheel ?? -1) + 1) % 4;
        this.act("wheel", { vehicle: s.letter, wheel: WHEELS[this.wheel] });
      } else {
        const tool = Object.entries(TOOLS).find(([, each]) => each[0].toLowerCase() === key.toLowerCase());
        if (tool) { this.use(tool[0]); this.cursor = this.m(this.w / 2, this.h / 2); this.view(); } else used = false;
      }
      if (used) event.preventDefault();
    },
    next(by) { // select the thing after
      const things = [];
      for (const car of this.d.cars) {
        if (car.at) things.push({ kind: "car", letter: car.letter, at: "impact" });
        if (car.rest) things.push({ kind: "car", letter: car.letter, at: "rest" });
        for (const mark of car.marks) things.push({ kind: "mark", letter: car.letter, number: mark[0] });
      }
      if (this.d.point) things.push({ kind: "point" });
      for (const ground of this.d.grounds) things.push({ kind: "ground", name: ground.name });
      if (!things.length) return;
      const i = things.findIndex((each) => this.same(each));
      this.sel = things[(i + by + things.length) % things.length];
      const s = this.sel;
      this.say(s.kind === "car" ? `${s.letter} ${s.at === "rest" ? "at rest" : "at the impact"}` : s.kind === "mark" ? `mark ${s.number + 1} of ${s.letter}` : s.kind === "point" ? "the impact point" : s.name);
      this.draw();
      this.pick();
    },
  },
};
