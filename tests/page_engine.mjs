// Runs a script on the page's engine in a worker of Node. In it `open(archive)` gives an engine, and `archives` are the files of the folder by
// name. node page_engine.mjs FOLDER SCRIPT, where FOLDER has engine.wasm, worker.js and archives and gets told.json, what the script returns.
import { readFileSync, readdirSync, writeFileSync } from "node:fs";
import { Engine } from "../master/page-files/page/engine.js";

const [, , folder, script] = process.argv;
const read = (name) => new Uint8Array(readFileSync(`${folder}/${name}`));
const archives = Object.fromEntries(readdirSync(folder).map((name) => [name, read(name)]));
const worker = readFileSync(`${folder}/worker.js`, "utf8");
const open = (system) => Engine.open({ engine: archives["engine.wasm"], system, worker });
const Script = Object.getPrototypeOf(async () => {}).constructor;
const told = await new Script("open", "archives", readFileSync(script, "utf8"))(open, archives);
writeFileSync(`${folder}/told.json`, JSON.stringify(told));
process.exit(0);
