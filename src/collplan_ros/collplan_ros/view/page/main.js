import { liveSource } from "./live.js";
import { start } from "./page.js";

start(liveSource());
