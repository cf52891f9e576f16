//! Tables, worked examples and printed outputs of the documents are what the code does.

mod examples;
mod extremes;
mod registers;
