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
  const says = book.querySelector("[data-says]");
  const labels = [...series[0].querySelectorAll(".frame")].map((frame) => frame.dataset.label);
  const state = { kind: kinds[0].dataset.kind, mode: "flip", step: Math.min(1, labels.length - 1) };

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
    slider.value = String(state.step);
    slider.setAttribute("aria-valuetext", label);
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
  show(buttons[0]);
}

document.querySelectorAll("[data-flip]").forEach(flipbook);
document.querySelectorAll("[data-chart]").forEach(chart);
document.querySelectorAll("[data-tabs]").forEach(tabs);

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
