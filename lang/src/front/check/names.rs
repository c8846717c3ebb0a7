//! What the names of a script stand for.

use std::collections::HashMap;
use std::rc::Rc;

use crate::front::ast::Name;
use crate::front::span::Span;
use crate::hir::{RoutineId, TableId, VarId};
use crate::kind::Kind;

/// What a name stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Entity {
    /// CONST; the value is None where its expression was wrong.
    Const(Kind, Option<i32>),
    /// INPUT (false) or OUTPUT (true) and its number, None where that was wrong.
    Port(bool, Option<i32>),
    /// An analog output (true) or ANALOG, an input, and its number, None where that was wrong.
    Analog(bool, Option<i32>),
    /// Variable, parameter or array.
    Var(VarId),
    /// TABLE
    Table(TableId),
    /// SUB or FUNCTION
    Routine(RoutineId),
}

/// A declared name.
#[derive(Clone, Debug)]
pub(super) struct Symbol<'a> {
    /// As written.
    pub text: &'a str,
    /// Where it was declared; None for a name of the profile.
    pub span: Option<Span>,
    /// What it stands for.
    pub entity: Entity,
    /// Whether anything mentions it.
    pub used: bool,
}

/// Names of the whole script and of each routine. Scope 0 is the main program's: its names are
/// visible everywhere, those of a routine hide them.
#[derive(Debug, Default)]
pub(super) struct Names<'a> {
    symbols: Vec<Symbol<'a>>,
    scopes: Vec<HashMap<Rc<str>, usize>>,
}

impl<'a> Names<'a> {
    /// Empty scopes for `routines` routines, the main program included.
    pub fn new(routines: usize) -> Names<'a> {
        Names { symbols: Vec::new(), scopes: vec![HashMap::new(); routines] }
    }

    /// Declares a name in a scope.
    ///
    /// # Errors
    /// Where the scope has that name already: the place of the first declaration.
    pub fn declare(
        &mut self,
        scope: RoutineId,
        name: &'a Name,
        entity: Entity,
    ) -> Result<(), Option<Span>> {
        let Some(names) = self.scopes.get_mut(scope.0 as usize) else { return Ok(()) };
        if let Some(&first) = names.get(&name.key) {
            // A script may give a number of the profile a name of its own.
            if let Some(span) = self.symbols[first].span {
                if name.span.start < span.start {
                    self.symbols[first].span = Some(name.span);
                }
                return Err(Some(span));
            }
        }
        names.insert(name.key.clone(), self.symbols.len());
        self.symbols.push(Symbol { text: &name.text, span: Some(name.span), entity, used: false });
        Ok(())
    }

    /// A name that the profile brings; the script's own hide it.
    pub fn predeclare(&mut self, text: &'a str, entity: Entity) {
        if let Some(names) = self.scopes.first_mut() {
            names.entry(text.to_lowercase().into()).or_insert(self.symbols.len());
            self.symbols.push(Symbol { text, span: None, entity, used: true });
        }
    }

    fn find(&self, scope: RoutineId, key: &str) -> Option<usize> {
        let local = self.scopes.get(scope.0 as usize)?.get(key);
        local.or_else(|| self.scopes.first()?.get(key)).copied()
    }

    /// What a name stands for inside a scope.
    pub fn look(&self, scope: RoutineId, key: &str) -> Option<Entity> {
        self.find(scope, key).map(|i| self.symbols[i].entity)
    }

    /// The same, and the name counts as used.
    pub fn take(&mut self, scope: RoutineId, key: &str) -> Option<Symbol<'a>> {
        let index = self.find(scope, key)?;
        self.symbols[index].used = true;
        Some(self.symbols[index].clone())
    }

    /// Names that are visible in a scope, for proposals.
    pub fn visible(&self, scope: RoutineId) -> impl Iterator<Item = &'a str> {
        let scopes = [self.scopes.get(scope.0 as usize), self.scopes.first()];
        let mut names: Vec<&'a str> = scopes
            .into_iter()
            .flatten()
            .flat_map(|s| s.values())
            .map(|&i| self.symbols[i].text)
            .collect();
        // Hash order differs between runs; proposals must not.
        names.sort_unstable();
        names.into_iter()
    }

    /// Every declared name.
    pub fn declared(&self) -> impl Iterator<Item = &Symbol<'a>> {
        self.symbols.iter()
    }

    /// Declared names that nothing mentions; those of the compiler have a blank in them.
    pub fn unused(&self) -> impl Iterator<Item = &Symbol<'a>> {
        self.symbols.iter().filter(|s| !s.used && !s.text.contains(' '))
    }
}
