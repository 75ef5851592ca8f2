// Light or dark: the system's setting until the user chooses, which is remembered.
export type Theme = "light" | "dark";

const key = "cwm-theme";

// Storage may be unavailable; then the choice is not remembered.
function stored(): Theme | undefined {
  try {
    const value = window.localStorage.getItem(key);
    return value === "light" || value === "dark" ? value : undefined;
  } catch {
    return undefined;
  }
}

function store(theme: Theme): void {
  try {
    window.localStorage.setItem(key, theme);
  } catch {
    // not remembered
  }
}

export class ThemeSwitch {
  private readonly system = window.matchMedia("(prefers-color-scheme: dark)");

  constructor(private readonly changed: () => void) {
    const chosen = stored();
    if (chosen) document.documentElement.dataset["theme"] = chosen;
    this.system.addEventListener("change", changed);
  }

  get now(): Theme {
    const chosen = document.documentElement.dataset["theme"];
    if (chosen === "light" || chosen === "dark") return chosen;
    return this.system.matches ? "dark" : "light";
  }

  toggle(): void {
    const theme = this.now === "dark" ? "light" : "dark";
    document.documentElement.dataset["theme"] = theme;
    store(theme);
    this.changed();
  }
}

// A colour of the style sheet.
export const styleColor = (name: string): string =>
  getComputedStyle(document.documentElement).getPropertyValue(name).trim();
