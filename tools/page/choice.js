// What is chosen in a section: one muscle, and which backends are shown. Charts and views of the section follow it.

import { label } from "./words.js";

const LIGHTER = 0.3;

export class Choice extends EventTarget {
  constructor(muscle, looks) {
    super();
    this.muscle = muscle;
    this.looks = looks;
    this.hidden = new Set();
  }

  shows(backend) {
    return !this.hidden.has(backend);
  }

  // As people write it.
  name(backend) {
    return this.looks[backend]?.label ?? label(backend);
  }

  // On a dark page lighter.
  colour(backend) {
    const colour = this.looks[backend]?.colour ?? "#888888";
    if (!matchMedia("(prefers-color-scheme: dark)").matches) return colour;
    const parts = [1, 3, 5].map((at) => parseInt(colour.slice(at, at + 2), 16));
    return `#${parts.map((part) => Math.round(part + LIGHTER * (255 - part)).toString(16).padStart(2, "0")).join("")}`;
  }

  change() {
    this.dispatchEvent(new Event("change"));
  }
}

export function choiceOf(section) {
  const looks = JSON.parse(section.dataset.looks);
  const select = section.querySelector(".choose-muscle");
  const choice = new Choice(select?.value ?? null, looks);
  select?.addEventListener("change", () => {
    choice.muscle = select.value;
    choice.change();
  });
  for (const button of section.querySelectorAll(".choose-backend[aria-pressed=false]")) choice.hidden.add(button.value);
  const filter = section.querySelector(".filter-backends");
  filter?.addEventListener("input", () => {
    const words = filter.value.toLowerCase();
    for (const button of section.querySelectorAll(".found .choose-backend")) button.hidden = !button.textContent.toLowerCase().includes(words);
  });
  for (const button of section.querySelectorAll(".choose-backend")) {
    button.addEventListener("click", () => {
      const name = button.value;
      if (!choice.hidden.delete(name)) choice.hidden.add(name);
      button.setAttribute("aria-pressed", String(choice.shows(name)));
      choice.change();
    });
  }
  return choice;
}
