// The page that shows a world as it changes. Data flows one way: socket, model, things, picture and panels.
import { element } from "../page/dom";
import { Link } from "./link";
import { Page } from "./page";

// The connection is opened while the picture is being prepared.
const link = new Link("/worker.js");

try {
  new Page(document.body, link);
} catch (error) {
  // A browser without WebGL 2 cannot draw.
  document.body.replaceChildren(element("p", "missing", `The world cannot be drawn here: ${String(error)}`));
}
