// What mdbook's pages lack for keyboards and screen readers: names and roles of its bar, and a focus for what scrolls.
(() => {
  const set = (selector, attributes) => {
    for (const element of document.querySelectorAll(selector)) {
      for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
    }
  };
  set("#mdbook-menu-bar", { role: "banner" });
  // A label may not be expanded.
  const toggle = document.getElementById("mdbook-sidebar-toggle");
  const plain = () => toggle.removeAttribute("aria-expanded");
  plain();
  new MutationObserver(plain).observe(toggle, { attributeFilter: ["aria-expanded"] });
  set("#mdbook-searchbar", { "aria-label": "Search" });
  set("#mdbook-help-container", { role: "dialog", "aria-label": "Keyboard shortcuts" });
  const scrolls = () => {
    for (const part of document.querySelectorAll("pre > code, .table-wrapper, math")) {
      if (part.scrollWidth > part.clientWidth) part.tabIndex = 0;
      else part.removeAttribute("tabindex");
    }
  };
  scrolls();
  addEventListener("resize", scrolls);
  addEventListener("load", scrolls);
})();
