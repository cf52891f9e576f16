//! The command as a user types it: flags, exit statuses, JSON keys, messages, files.

mod commands;
mod conformance;
mod fingerprint;
mod gpu_scenes;
mod images;
mod inputs;
mod output;
mod run;
mod size;
mod study_asked;
mod study_report;
mod study_results;
mod tex;
mod trace;
mod unit;
