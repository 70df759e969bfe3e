//! Commands that write pages for a browser.

pub mod report;
pub mod view;
