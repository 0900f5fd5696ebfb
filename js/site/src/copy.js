// Buttons that copy a listing.

/** text(): what is copied. */
export function copyOnClick(button, text) {
  button.addEventListener("click", async () => {
    await navigator.clipboard.writeText(text());
    button.textContent = "Copied";
    setTimeout(() => (button.textContent = "Copy"), 2000);
  });
}
