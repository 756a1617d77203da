// The page is complete without this; with it, pictures can be flipped through in place and curves singled out.
"use strict";
document.documentElement.classList.add("js");

function press(buttons, chosen) {
  for (const button of buttons) button.setAttribute("aria-pressed", String(button === chosen));
}

function flipbook(book) {
  const kinds = [...book.querySelectorAll("[data-kind]")];
  const modes = [...book.querySelectorAll("[data-mode]")];
  const steps = [...book.querySelectorAll("[data-step]")];
  const series = [...book.querySelectorAll("[data-series]")];
  const slider = book.querySelector("input[type=range]");
  const strip = book.querySelector(".slider");
  const says = book.querySelector("[data-says]");
  const labels = [...series[0].querySelectorAll(".frame")].map((frame) => frame.dataset.label);
  const state = { kind: kinds[0].dataset.kind, mode: "grid", step: Math.min(1, labels.length - 1) };

  function show() {
    const label = labels[state.step];
    book.classList.toggle("grid", state.mode === "grid");
    for (const one of series) {
      one.hidden = one.dataset.series !== state.kind;
      for (const frame of one.querySelectorAll("[data-label]")) {
        const wanted = state.mode === "grid" ? !frame.classList.contains("absent") : frame.dataset.label === label;
        frame.hidden = !wanted;
        if (wanted && !one.hidden && state.mode === "flip") says.textContent = frame.textContent.trim().replace(/\s+/g, " ");
      }
    }
    strip.hidden = state.mode === "grid";
    slider.value = String(state.step);
    slider.setAttribute("aria-valuetext", steps[state.step].textContent.trim());
    press(kinds, kinds.find((button) => button.dataset.kind === state.kind));
    press(modes, modes.find((button) => button.dataset.mode === state.mode));
    press(steps, state.mode === "flip" ? steps[state.step] : null);
  }

  const change = (changes) => () => (Object.assign(state, changes), show());
  for (const button of kinds) button.addEventListener("click", change({ kind: button.dataset.kind }));
  for (const button of modes) button.addEventListener("click", change({ mode: button.dataset.mode }));
  for (const button of steps) {
    button.addEventListener("click", change({ step: Number(button.dataset.step), mode: "flip" }));
  }
  slider.addEventListener("input", () => change({ step: Number(slider.value), mode: "flip" })());
  show();
}

function chart(figure) {
  const buttons = [...figure.querySelectorAll("button[data-curve]")];
  function single(curve) {
    figure.classList.toggle("singled", curve !== null);
    for (const part of figure.querySelectorAll("svg [data-curve]")) {
      part.classList.toggle("chosen", part.dataset.curve === curve);
    }
  }
  const pressed = () => buttons.find((button) => button.getAttribute("aria-pressed") === "true");
  const settle = () => single(pressed()?.dataset.curve ?? null);
  for (const button of buttons) {
    button.addEventListener("click", () => (press(buttons, pressed() === button ? null : button), settle()));
    button.addEventListener("pointerenter", () => single(button.dataset.curve));
    button.addEventListener("pointerleave", settle);
  }
}

function tabs(group) {
  const buttons = [...group.querySelectorAll("[data-tab]")];
  const panels = [...group.querySelectorAll("[data-panel]")];
  function show(button) {
    press(buttons, button);
    for (const panel of panels) panel.hidden = panel.dataset.panel !== button.dataset.tab;
  }
  for (const button of buttons) button.addEventListener("click", () => show(button));
  if (buttons.length) show(buttons[0]);
}

function scroller(box) {
  const look = () => box.classList.toggle("wider", box.scrollWidth - box.clientWidth - box.scrollLeft > 8);
  box.addEventListener("scroll", look, { passive: true });
  new ResizeObserver(look).observe(box);
}

function film(section) {
  const end = Number(section.dataset.film);
  const reels = [...section.querySelectorAll(".reel")].map((element) => ({
    element,
    times: JSON.parse(element.dataset.times),
    says: JSON.parse(element.dataset.says),
    columns: Number(element.dataset.columns),
    rows: Number(element.dataset.rows),
  }));
  const moments = [...new Set(reels.flatMap((reel) => reel.times))].sort((a, b) => a - b);
  const find = (name) => section.querySelector(name);
  const [play, back, on, slider, says, speed] = ["[data-play]", "[data-back]", "[data-on]", "input", "output", "select"].map(find);
  const still = matchMedia("(prefers-reduced-motion: reduce)");
  let now = 0;
  let last = null; // when the clock was looked at, while it runs

  function show(time) {
    now = Math.min(Math.max(time, 0), end);
    for (const reel of reels) {
      const number = reel.times.filter((moment) => moment <= now).length - 1;
      const place = Math.max(number, 0);
      const stage = reel.element.querySelector(".stage");
      stage.classList.toggle("empty", number < 0);
      stage.firstElementChild.style.transform =
        `translate(${(-100 * (place % reel.columns)) / reel.columns}%, ${(-100 * Math.floor(place / reel.columns)) / reel.rows}%)`;
      reel.element.dataset.frame = String(number);
      reel.element.querySelector("[data-now]").textContent = number < 0 ? "no sample yet" : reel.says[number];
    }
    slider.value = String((slider.max * now) / end);
    says.textContent = `${now.toFixed(now < 1 ? 3 : 2)} s`;
    slider.setAttribute("aria-valuetext", says.textContent);
  }

  function tick(clock) {
    if (last === null) return;
    show(now + (Number(speed.value) * Math.max(clock - last, 0)) / 1000);
    last = clock;
    if (now < end) requestAnimationFrame(tick);
    else stop();
  }

  function stop() {
    last = null;
    play.textContent = "Play";
  }

  function start() {
    if (now >= end) show(0);
    last = performance.now();
    play.textContent = "Pause";
    requestAnimationFrame(tick);
  }

  const jump = (time) => (stop(), show(time));
  const calm = () => (stop(), (play.hidden = speed.parentElement.hidden = still.matches));
  play.addEventListener("click", () => (last === null ? start() : stop()));
  back.addEventListener("click", () => jump(moments.filter((moment) => moment < now).at(-1) ?? 0));
  on.addEventListener("click", () => jump(moments.find((moment) => moment > now) ?? end));
  slider.addEventListener("input", () => jump((end * slider.value) / slider.max));
  still.addEventListener("change", calm);
  calm();
  show(Math.max(...reels.map((reel) => reel.times[0])));
}

document.querySelectorAll("[data-film]").forEach(film);
document.querySelectorAll("[data-flip]").forEach(flipbook);
document.querySelectorAll("[data-chart]").forEach(chart);
document.querySelectorAll("[data-tabs]").forEach(tabs);
document.querySelectorAll(".scroll").forEach(scroller);

// paper shows everything: all panels, all frames, all numbers
addEventListener("beforeprint", () => {
  for (const details of document.querySelectorAll("details:not([open])")) {
    details.open = true;
    details.dataset.wasClosed = "";
  }
});
addEventListener("afterprint", () => {
  for (const details of document.querySelectorAll("details[data-was-closed]")) {
    details.open = false;
    delete details.dataset.wasClosed;
  }
});
