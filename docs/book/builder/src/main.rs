//! Builds the book whose folder is the only word: `jounce_book target/book-src`.

use mdbook_driver::MDBook;
use std::process::ExitCode;

fn main() -> ExitCode {
    let Some(folder) = std::env::args().nth(1) else {
        eprintln!("usage: jounce_book FOLDER");
        return ExitCode::FAILURE;
    };
    match MDBook::load(folder).and_then(|book| book.build()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => {
            eprintln!("jounce_book: {e:?}");
            ExitCode::FAILURE
        }
    }
}
