// What is chosen in a section: one muscle, and which backends are shown. Charts and views of the section follow it.

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

  colour(backend) {
    return this.looks[backend]?.colour ?? "#888888";
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
