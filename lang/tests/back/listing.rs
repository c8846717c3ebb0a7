//! Listings as snapshots: a change of the code that comes out is seen.

use lang::back::disasm;
use lang::image::Image;

#[test]
fn listings() {
    let mut settings = insta::Settings::clone_current();
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    settings.set_snapshot_path("../data/back");
    settings.bind(|| {
        for file in super::scripts("back") {
            let text = std::fs::read_to_string(&file).unwrap();
            let compiled = super::compile(&text);
            let image = Image::new(&compiled.image).unwrap();
            let shown = format!(
                "{} statements, {} bytes of code, {} of tables, {} cells, stack {}, calls {}\n{}",
                compiled.statements,
                compiled.code_bytes,
                compiled.table_bytes,
                compiled.cells,
                compiled.stack,
                compiled.calls,
                disasm::listing(&image, Some(&compiled.sidecar)),
            );
            insta::assert_snapshot!(file.file_stem().unwrap().to_str().unwrap(), shown);
        }
    });
}

#[test]
fn every_script_of_the_checker_compiles_to_an_image_that_passes() {
    for file in super::scripts("check/ok") {
        let text = std::fs::read_to_string(&file).unwrap();
        for part in text.split("' ---\n") {
            super::compile(part);
        }
    }
}
