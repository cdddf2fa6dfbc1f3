// Formulas by KaTeX, where Sphinx has written them as \(...\) and \[...\].
document.addEventListener("DOMContentLoaded", () => {
  const delimiters = [
    { left: "\\(", right: "\\)", display: false },
    { left: "\\[", right: "\\]", display: true },
  ];
  const macros = { "\\dddot": "\\overset{...}{#1}" };
  for (const formula of document.querySelectorAll(".math")) {
    renderMathInElement(formula, { delimiters, macros, strict: false });
  }
});
