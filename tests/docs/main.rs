//! Tables, worked examples and printed outputs of the documents are what the code does.

mod commands;
mod examples;
mod extremes;
mod inputs;
mod registers;
