const field = document.getElementById("filter");
const said = document.querySelector(".filter [role=status]");
const plain = (text) => text.normalize("NFD").replace(/[\u0300-\u036f]/g, "").toLowerCase();
const terms = [...document.querySelectorAll(".term")].map((element) => [element, plain(element.textContent), plain(element.querySelector(".pinyin").textContent).replace(/[^a-z]/g, "")]);

function filter() {
  const wanted = plain(field.value.trim());
  let count = 0;
  for (const [element, text, pinyin] of terms) {
    element.hidden = !(text.includes(wanted) || pinyin.includes(wanted.replace(/ /g, "")));
    count += !element.hidden;
  }
  for (const section of document.querySelectorAll(".glossary section")) {
    section.hidden = !section.querySelector(".term:not([hidden])");
  }
  document.querySelector(".letters").hidden = wanted !== "";
  said.textContent = wanted === "" ? "" : count === 0 ? "no such word" : count + (count === 1 ? " word" : " words");
}

document.querySelector(".filter").hidden = false;
field.addEventListener("input", filter);
filter(); // a browser may bring the typed text back
