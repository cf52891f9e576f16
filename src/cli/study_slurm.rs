//! `study slurm`: an array job for each part, and one that merges them.

use std::path::Path;

use crate::study::plan::Plan;

/// A shell script that submits both jobs. Paths are made absolute, so that jobs find them in any folder.
pub(super) fn script(plan: &Plan, file: &Path, out: &Path, parts: u32, cpus: u32) -> String {
    let absolute = |p: &Path| {
        quoted(&std::path::absolute(p).unwrap_or_else(|_| p.into()).display().to_string())
    };
    let (file, out) = (absolute(file), absolute(out));
    let title: String =
        plan.title.chars().filter(|c| c.is_ascii_alphanumeric() || *c == '-').collect();
    format!(
        r#"#!/bin/sh
# {parts} parts of a study as an array job, then the job that merges them.
# A part that was stopped goes on where it was when the array is submitted again.
# TAPLINE names the binary; `tapline` is looked up in PATH otherwise.
set -eu
TAPLINE=${{TAPLINE:-tapline}}
OUT={out}
STUDY={file}
mkdir -p "$OUT"
parts=$(sbatch --parsable --job-name="tapline-{title}" --array=1-{parts} --cpus-per-task={cpus} \
    --output="$OUT/part-%a.log" \
    --wrap="'$TAPLINE' study '$STUDY' --out '$OUT' --shard \$SLURM_ARRAY_TASK_ID/{parts} --resume --threads {cpus}")
merge=$(sbatch --parsable --job-name="tapline-merge" --dependency="afterok:$parts" --output="$OUT/merge.log" \
    --wrap="'$TAPLINE' study merge '$OUT'/results-*-of-{parts}.jsonl --out '$OUT'")
echo "parts: job $parts; merge: job $merge"
"#
    )
}

fn quoted(text: &str) -> String {
    format!("'{}'", text.replace('\'', r"'\''"))
}
