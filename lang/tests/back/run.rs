//! Scripts run by the VM against a machine that answers at once: the effects, in order, with
//! lines, are snapshots. Every run goes through the public interface that engines use.

use core::fmt::Write as _;
use lang::back::Compiled;
use lang::effect::{Effect, Read};
use lang::fault::Fault;
use lang::image::Image;
use lang::plain::Plain;
use lang::vm::{Exit, State, Vm, flag};

/// Instructions after which a run counts as endless.
const MAX_STEPS: usize = 100_000;

/// How a run ended.
#[derive(Debug, PartialEq, Eq)]
pub enum Ended {
    Done,
    Fault(Fault),
    Endless,
}

/// A machine whose moves are done at once and whose inputs follow a plan.
#[derive(Default)]
pub struct Machine {
    log: String,
    reads: i32,
}

impl Machine {
    /// `IN(n)` and `CHARIN()` count the reads: 0, 1, 2, ... Everything else reads 0.
    fn perform(&mut self, image: &Image<'_>, line: u32, effect: &Effect) -> Result<i32, Fault> {
        match effect {
            Effect::PrintText(offset) => {
                let text = image.text(usize::from(*offset)).expect("verified");
                let _ = writeln!(self.log, "{line:>3} {:?}", String::from_utf8_lossy(text));
                return Ok(0);
            }
            Effect::Read(Read::In(_) | Read::CharIn) => {
                self.reads += 1;
                return Ok(self.reads - 1);
            }
            Effect::Read(Read::Timer) => return Ok(1000),
            Effect::Read(_) => return Ok(0),
            Effect::Plain(Plain::Wait, [ms, _]) if *ms < 0 => return Err(Fault::ValueRange),
            Effect::MoveAxe { to, .. } if to.value == lang::effect::Dist::Um(999_000) => {
                return Err(Fault::SoftLimit);
            }
            _ => {}
        }
        let _ = writeln!(self.log, "{line:>3} {effect:?}");
        Ok(0)
    }
}

/// Runs a program; gives the log, the cells and the end.
pub fn run(compiled: &Compiled) -> (String, Vec<i32>, Ended) {
    let image = Image::new(&compiled.image).unwrap();
    let mut state = State::new(&image.header);
    let mut pool = vec![0; image.header.pool_bytes()];
    let mut machine = Machine::default();
    let mut registered = Vec::new();
    let line_of = |pc| compiled.sidecar.at(pc).map_or(0, |mark| mark.line);
    let mut ended = Ended::Endless;
    for _ in 0..MAX_STEPS {
        let mut vm = Vm::new(image, &mut state, &mut pool);
        match vm.run(1) {
            Exit::Budget | Exit::Course(_) => {}
            Exit::Effect => {
                let line = line_of(vm.state.pc);
                let effect = vm.effect().expect("verified");
                match machine.perform(&image, line, &effect) {
                    Ok(result) => {
                        vm.complete(result);
                        if let Effect::OnInput { slot, .. } | Effect::OnEvery { slot, .. } = effect
                        {
                            registered.push(slot);
                        }
                        // Every wait lets each event come once.
                        if let Effect::Plain(Plain::Wait, _) = effect
                            && vm.can_interrupt()
                            && let Some(slot) = registered.pop()
                        {
                            vm.interrupt(slot).unwrap();
                        }
                    }
                    Err(fault) => match vm.fault(fault) {
                        Ok(()) => {}
                        Err(fault) => {
                            ended = Ended::Fault(fault);
                            break;
                        }
                    },
                }
            }
            Exit::HandlerEnd => {
                let open = vm.state.flags & (flag::EVENT | flag::ERROR);
                let _ = writeln!(machine.log, "    handler left, {open} open");
            }
            Exit::Fault(fault) => {
                let line = line_of(vm.state.pc);
                let _ = writeln!(machine.log, "{line:>3} {fault}");
                if let Err(fault) = vm.fault(fault) {
                    ended = Ended::Fault(fault);
                    break;
                }
            }
            Exit::End => {
                ended = Ended::Done;
                break;
            }
        }
    }
    let vm = Vm::new(image, &mut state, &mut pool);
    let cells = (0..image.header.cells).map(|n| vm.cell(n as u8)).collect();
    (machine.log, cells, ended)
}

#[test]
fn runs() {
    let mut settings = insta::Settings::clone_current();
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    settings.set_snapshot_path("../data/run");
    settings.bind(|| {
        for file in super::scripts("run") {
            let text = std::fs::read_to_string(&file).unwrap();
            let compiled = super::compile(&text);
            let (log, cells, ended) = run(&compiled);
            let shown = format!("{log}{ended:?}\ncells {cells:?}\n");
            insta::assert_snapshot!(file.file_stem().unwrap().to_str().unwrap(), shown);
        }
    });
}

/// The values that `PRINT` writes when the script runs to its end.
fn printed(text: &str) -> Vec<i32> {
    let compiled = super::compile(text);
    let (log, _, ended) = run(&compiled);
    assert_eq!(ended, Ended::Done, "{text}\n{log}");
    let parts = log.split("PrintValue(").skip(1).filter_map(|rest| rest.split(',').next());
    parts.map(|value| value.parse().unwrap()).collect()
}

#[test]
fn constants_of_every_form_arrive() {
    let mut values: Vec<i64> = Vec::new();
    for power in 0..32 {
        let near = 1i64 << power;
        values.extend([near - 1, near, near + 1, -near, -near - 1, -near + 1]);
        values.extend([near * 10, near * 100, near * 1000, near * -10, near * -1000]);
    }
    values.retain(|value| i32::try_from(*value).is_ok());
    values.sort_unstable();
    values.dedup();
    let text: String = values.iter().map(|value| format!("PRINT {value}\n")).collect();
    let values: Vec<i32> = values.into_iter().map(|value| value as i32).collect();
    assert_eq!(printed(&text), values);
}
