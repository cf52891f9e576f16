//! docs/commands.md is what the command line says of itself.

use clap_markdown::{MarkdownOptions, help_markdown_command_custom};
use support::{golden, house};

#[test]
fn the_page_of_commands_is_what_the_command_line_defines() {
    let options = MarkdownOptions::new()
        .title("Commands".into())
        .show_footer(false)
        .show_table_of_contents(true);
    let page = help_markdown_command_custom(&tapline::cli::command(), &options);
    let bless = std::env::var_os(golden::BLESS).is_some();
    if let Err(message) = golden::compare(&house::root("docs/commands.md"), &page, bless) {
        panic!("{message}");
    }
}
