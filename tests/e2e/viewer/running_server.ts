// A real server on sockets of its own, driven by the real command line.
import { execFile, spawn, type ChildProcess } from "node:child_process";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { promisify } from "node:util";

const run = promisify(execFile);

const patience_ms = 20_000;

export const pause = (ms: number): Promise<void> => new Promise((resolve) => setTimeout(resolve, ms));

export async function until(what: string, holds: () => boolean | Promise<boolean>): Promise<void> {
  for (const end = Date.now() + patience_ms; Date.now() < end; await pause(20)) {
    if (await holds()) return;
  }
  throw new Error(`waited in vain until ${what}`);
}

// The programs of this build, from the environment that ctest sets.
const program = (name: string): string => join(process.env["CWM_BIN"] ?? "build/bin", name);

export class RunningServer {
  readonly folder = mkdtempSync(join(tmpdir(), "cwm-viewer-"));
  url = "";
  private child: ChildProcess | undefined;
  private log = "";

  // Starts on the previous port if it ran before; with a token if one is given.
  async start(token = ""): Promise<void> {
    const viewer = this.url === "" ? "127.0.0.1:0" : new URL(this.url).host;
    this.log = "";
    const child = spawn(program("cwm-server"), ["--listen", this.address, "--viewer", viewer], {
      stdio: ["ignore", "ignore", "pipe"], env: { ...process.env, CWM_VIEWER_TOKEN: token } });
    this.child = child;
    child.stderr?.on("data", (text: Buffer) => { this.log += text.toString(); });
    await until(`the server told where it shows the world; it says: ${this.log}`, () => /http:\S+/.test(this.log));
    this.url = /http:\S+/.exec(this.log)?.[0] ?? "";
  }

  // Stops the process without closing its connections, like a pulled cable, until goOn.
  freeze(): void { this.child?.kill("SIGSTOP"); }
  goOn(): void { this.child?.kill("SIGCONT"); }

  // Throws if the server does not end by itself.
  async stop(): Promise<void> {
    const child = this.child;
    if (!child) return;
    this.child = undefined;
    const ended = new Promise<number | null>((resolve) => child.once("exit", resolve));
    child.kill("SIGCONT");  // a test that failed may have left it frozen
    child.kill("SIGTERM");
    const code = await ended;
    if (code !== 0) throw new Error(`the server ended with ${code}: ${this.log}`);
  }

  async close(): Promise<void> {
    await this.stop();
    rmSync(this.folder, { recursive: true });
  }

  // The output of the command; throws with its error message.
  async cwm(...words: string[]): Promise<string> {
    const { stdout } = await run(program("cwm"), ["--addr", this.address, ...words], { maxBuffer: 1 << 28 });
    return stdout;
  }

  // The grasp planner's result as the contents of its file.
  async grasps(...words: string[]): Promise<string> {
    const path = join(this.folder, "grasps.json");
    await run(program("cwm-grasp"), ["--addr", this.address, "--json", path, ...words]);
    return path;
  }

  async json(...words: string[]): Promise<Record<string, unknown>> {
    return JSON.parse(await this.cwm("-o", "json", ...words)) as Record<string, unknown>;
  }

  async apply(changes: readonly object[]): Promise<void> {
    await this.cwm("call", "ApplyChanges", `@${this.write("changes.json", JSON.stringify({ changes }))}`);
  }

  // Ingests the demo's kitchen as seen by a camera.
  async ingestKitchen(): Promise<void> {
    const cloud = join(this.folder, "kitchen.pcd");
    await run(program("cwm-simulator"), ["--scene", "kitchen", "--out", cloud, "--truth", join(this.folder, "kitchen.json")]);
    const { stdout: pose } = await run(program("cwm-simulator"), ["--scene", "kitchen", "--print-pose"]);
    await this.cwm("ingest", cloud, "--x-world-sensor", pose.trim());
  }

  // Renders the sequence of a script; returns its folder, with one for each sensor.
  async simulate(script: string): Promise<string> {
    const folder = join(this.folder, "sequence");
    await run(program("cwm-simulator"), ["--script", this.write("script.yaml", script), "--out", folder], { maxBuffer: 1 << 28 });
    return folder;
  }

  write(name: string, text: string): string {
    const path = join(this.folder, name);
    writeFileSync(path, text);
    return path;
  }

  get socketPath(): string { return join(this.folder, "cwm.sock"); }

  private get address(): string { return `unix:${this.socketPath}`; }
}
