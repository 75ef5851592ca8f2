// The page that shows a world as it changes. Data flows one way: socket, model, objects, picture and panels.
import { element } from "../page/dom";
import { RpcClient } from "./rpc_client";
import { Page } from "./page";

// The connection is opened while the picture is being prepared.
const client = new RpcClient("/worker.js");

try {
  new Page(document.body, client);
} catch (error) {
  // A browser without WebGL 2 cannot draw.
  document.body.replaceChildren(element("p", "missing", `The world cannot be drawn here: ${String(error)}`));
}
