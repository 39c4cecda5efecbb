"use strict";
for (const root of document.querySelectorAll(".replay:not(.live)")) {
  const data = JSON.parse(root.querySelector(".data").textContent);
  const find = (name) => root.querySelector(name);
  const [play, time, pick, clock, speeds] =
    [".play", ".time", ".pick", ".clock", ".speeds"].map(find);
  const vehicles = Object.keys(data.draws[0].rows);
  const still = matchMedia("(prefers-reduced-motion: reduce)");
  const STEP = 0.1;  // s of a step where motion is to be reduced
  let frame = 0;
  let last = 0;

  const draw = () => data.draws[Number(pick.value)];

  // place, heading and speed of a vehicle at a time, between the rows of its path
  function pose([t, x, y, heading], now) {
    let i = 1;
    while (i < t.length - 1 && t[i] < now) i += 1;
    const lasts = t[i] - t[i - 1];
    const share = Math.min(1, Math.max(0, (now - t[i - 1]) / lasts));
    const between = (of) => of[i - 1] + share * (of[i] - of[i - 1]);
    const moved = Math.hypot(x[i] - x[i - 1], y[i] - y[i - 1]);
    const speed = now >= t[t.length - 1] ? 0 : moved / lasts / data.scale;
    return { x: between(x), y: between(y), heading: between(heading), speed };
  }

  function show() {
    const now = Number(time.value);
    const texts = [];
    for (const v of vehicles) {
      const at = pose(draw().rows[v], now);
      find(`.body.${v}`).setAttribute("transform",
        `translate(${at.x} ${at.y}) rotate(${at.heading})`);
      find(`.name.moving.${v}`).setAttribute("transform", `translate(${at.x} ${at.y})`);
      texts.push(`${v.toUpperCase()} ${at.speed.toFixed(0)} ${data.unit}`);
    }
    const when = `${Math.abs(now).toFixed(2)} s ${now < 0 ? "before" : "after"} impact`;
    clock.textContent = when;
    speeds.textContent = texts.join(", ");
    time.setAttribute("aria-valuetext", `${when}; ${texts.join(", ")}`);
  }

  function choose() {
    time.max = draw().lasts;
    for (const v of vehicles) {
      const [, x, y] = draw().rows[v];
      find(`.path.moving.${v}`).setAttribute("points",
        x.slice(1).map((each, i) => `${each},${y[i + 1]}`).join(" "));
    }
    show();
  }

  function stop() {
    cancelAnimationFrame(frame);
    frame = 0;
    play.textContent = still.matches ? "Step" : "Play";
  }

  function tick(now) {
    time.value = Number(time.value) + (now - last) / 1000;
    last = now;
    show();
    if (Number(time.value) >= Number(time.max)) stop();
    else frame = requestAnimationFrame(tick);
  }

  play.addEventListener("click", () => {
    const atEnd = Number(time.value) >= Number(time.max);
    if (frame) return stop();
    if (atEnd) time.value = time.min;
    if (still.matches) {
      if (!atEnd) time.value = Number(time.value) + STEP;
      return show();
    }
    play.textContent = "Pause";
    last = performance.now();
    frame = requestAnimationFrame(tick);
  });
  time.addEventListener("input", () => { stop(); show(); });
  pick.addEventListener("input", choose);
  still.addEventListener("change", stop);
  root.classList.add("live");
  choose();
  stop();
}
