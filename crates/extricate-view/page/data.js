// What the page was made of.

const DATA = JSON.parse(document.getElementById("data").textContent);
const SCENE = DATA.scene;
