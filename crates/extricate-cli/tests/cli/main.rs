//! Tests the command line from outside: exit codes, standard output and error, files. The library's
//! tests judge depths.

mod bad_input;
mod demo;
mod distances;
mod faults;
mod friendly;
mod grasps;
mod importing;
mod kills;
mod learning;
mod motions;
mod no_model;
mod packages;
mod pipeline;
mod process;
mod readers;
mod repeatable;
mod streams;
mod view;
mod worlds;
