"use strict";
(() => {
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

  button.addEventListener("click", () => {
    const { run } = document.querySelector("main").dataset;
    const text = JSON.stringify({ hsr: 1, run, decisions: decided() }, null, 1);
    const link = document.createElement("a");
    link.href = `data:application/json,${encodeURIComponent(text)}`;
    link.download = "decisions.json";
    link.click();
  });
})();
