"use strict";
(() => {
  const entries = [...document.querySelectorAll("[data-state]")];
  const state = document.getElementById("state");
  const words = document.getElementById("words");

  // What is chosen: a state and words that a check's text has.
  function filter() {
    const text = words.value.toLowerCase();
    for (const entry of entries) {
      const states = entry.dataset.state.split("|");
      const fits = !state.value || states.includes(state.value);
      entry.hidden = !fits || !entry.textContent.toLowerCase().includes(text);
    }
    const shown = entries.filter((entry) => !entry.hidden).length;
    document.getElementById("matching").textContent = `${shown} of ${entries.length} checks`;
  }

  state.addEventListener("change", filter);
  words.addEventListener("input", filter);

  const button = document.getElementById("download");
  if (!button) return;
  const fields = [...document.querySelectorAll("fieldset[data-check]")];

  function decided() {
    const chosen = fields.map((field) => [field.dataset.check, field.querySelector(":checked")?.value]);
    return Object.fromEntries(chosen.filter(([, choice]) => choice));
  }

  for (const field of fields) {
    field.addEventListener("change", () => {
      button.disabled = false;
    });
  }

  // Only what is shown, and not yet decided.
  document.getElementById("all").addEventListener("click", () => {
    for (const field of fields) {
      if (!field.closest("[hidden]") && !field.querySelector(":checked")) {
        field.querySelector("[value=accept]").click();
      }
    }
  });

  button.addEventListener("click", () => {
    const { run } = document.querySelector("main").dataset;
    const text = JSON.stringify({ hsr: 1, run, decisions: decided() }, null, 1);
    const link = document.createElement("a");
    link.href = `data:application/json,${encodeURIComponent(text)}`;
    link.download = "decisions.json";
    link.click();
  });
})();
