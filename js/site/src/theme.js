// Dark or light theme: the system's preference until the user chooses. Players follow.

const KEY = "fvv-theme";
const root = document.documentElement;
const dark = matchMedia("(prefers-color-scheme: dark)");

function apply(theme) {
  if (theme) root.dataset.theme = theme;
  for (const player of document.querySelectorAll("fvv-player")) if (theme) player.setAttribute("theme", theme);
}

function toggle() {
  const current = root.dataset.theme ?? (dark.matches ? "dark" : "light");
  const next = current === "dark" ? "light" : "dark";
  localStorage.setItem(KEY, next);
  apply(next);
}

apply(localStorage.getItem(KEY));
for (const button of document.querySelectorAll("[data-theme-toggle]")) button.addEventListener("click", toggle);
